/// Recipes: the first byte chooses the kind of file, then each alteration is one byte and its arguments (missing bytes are zero). Built
/// this way every input reaches the checks behind HDF5's own, and an input is a few bytes long.

#include <fmt/format.h>
#include <hdf5.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/snapshot.hpp"
#include "memory_file.hpp"
#include "support/impact_history.hpp"
#include "support/temporary_directory.hpp"
#include "targets.hpp"

namespace mpm::fuzz {

namespace {

constexpr const char* hash = "0123456789abcdef";
constexpr double cell_size = 0.25;

Case small_case() {
  Case c;
  c.material = HenckyElastic::Parameters{};
  c.numerics.cell_size = cell_size;
  BodySpec body;
  body.min = Vec3(0.0, 0.0, 0.0);
  body.max = Vec3(0.5, 0.5, 0.5);
  c.bodies.push_back(body);
  WallSpec floor;
  floor.contact = Contact::separable;
  c.walls.push_back(floor);
  return c;
}

ImpactGeometry geometry() { return paper_geometry(1.75, 1.75, cell_size, 300.0, false); }

/// The three files as this program writes them, without their seals.
struct Originals {
  std::array<std::string, 3> images;

  Originals() {
    const testing::TemporaryDirectory directory;
    const Case c = small_case();
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    step(state, scene, 1e-4);
    std::vector<testing::ImpactSample> samples(3);
    for (std::size_t k = 0; k < samples.size(); ++k) {
      samples[k].time = 0.02 * static_cast<double>(k);
      samples[k].pressure.assign(geometry().profile_bins(), 0.0);
    }
    RunProgress progress;
    progress.samples = 3;
    progress.initial_particles = state.grid.particle_count();
    const SnapshotInfo info{.time = state.time, .step = 1, .case_hash = hash, .version = "0", .reference_density = 300.0};
    const ParticleTable particles = particle_table(state, scene);
    write_checkpoint(directory / "0", c, state, progress, testing::arrays_of(samples, geometry()));
    frame_writer(directory.path(), 0, info).write(particles);
    SnapshotWriter(SnapshotKind::final, directory / "2", info).write(particles);
    const std::filesystem::path paths[] = {directory / "0", frame_path(directory.path(), 0), directory / "2"};
    constexpr std::size_t seal = 16;
    for (std::size_t i = 0; i < images.size(); ++i) {
      images[i] = read_file(paths[i]);
      images[i].resize(images[i].size() - seal);
    }
  }
};

/// Takes the bytes of a recipe one after the other.
class Recipe {
 public:
  explicit Recipe(Bytes bytes) : bytes_(bytes) {}
  [[nodiscard]] bool more() const { return at_ < bytes_.size(); }
  std::size_t byte() { return more() ? bytes_[at_++] : 0; }
  std::size_t word() { return byte() << 8 | byte(); }

 private:
  Bytes bytes_;
  std::size_t at_ = 0;
};

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::array special_reals{0.0,        -1.0,      std::numeric_limits<double>::quiet_NaN(),
                                   infinity,   -infinity, 1e300,
                                   -1e300,     5e-324,    0.125,
                                   1e6,        -1e6,      1e18,
                                   1.0,        -0.0,      0.499999,
                                   0.50000001, 2.0};
constexpr std::array<std::int64_t, 12> special_integers{0,
                                                        1,
                                                        -1,
                                                        2,
                                                        63,
                                                        64,
                                                        65,
                                                        255,
                                                        70000,
                                                        std::numeric_limits<std::int32_t>::max(),
                                                        std::numeric_limits<std::int64_t>::max(),
                                                        std::numeric_limits<std::int64_t>::min()};
constexpr std::array<hsize_t, 8> special_extents{0, 1, 2, 3, 64, 65, 1000, 8};

/// Names in the root group, or of its attributes, in the order of their names.
std::vector<std::string> dataset_names(hid_t file) {
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  H5Literate(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names);
  return names;
}
std::vector<std::string> attribute_names(hid_t file) {
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5A_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  H5Aiterate2(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names);
  return names;
}

hid_t some_type(std::size_t n) {
  const std::array<hid_t, 7> types{H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_U64LE, H5T_STD_I64LE,
                                   H5T_STD_I32LE,  H5T_STD_U8LE,   H5T_STD_U16BE};
  return types[n % types.size()];
}

/// A type that closes itself with its last copy.
using Type = std::shared_ptr<const hid_t>;
Type owned(hid_t type) {
  return {new hid_t(type), [](const hid_t* id) {
            H5Tclose(*id);
            delete id;
          }};
}

struct Array {
  Type type;
  std::vector<hsize_t> extents;
  std::vector<unsigned char> bytes;
};

Array read_array(hid_t file, const std::string& name) {
  const hid_t set = H5Dopen2(file, name.c_str(), H5P_DEFAULT), space = H5Dget_space(set);
  Array a{owned(H5Dget_type(set)), std::vector<hsize_t>(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space))), {}};
  H5Sget_simple_extent_dims(space, a.extents.data(), nullptr);
  a.bytes.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)) * H5Tget_size(*a.type));
  if (!a.bytes.empty()) H5Dread(set, *a.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, a.bytes.data());
  H5Sclose(space);
  H5Dclose(set);
  return a;
}

/// Puts an array in the place of the one with that name; bytes that are missing are zero.
void replace_array(hid_t file, const std::string& name, Array a) {
  constexpr hsize_t most = 1 << 16;  // values; what is larger is not for want of checks
  hsize_t values = 1;
  for (const hsize_t n : a.extents) values *= n;
  if (values > most) return;
  H5Ldelete(file, name.c_str(), H5P_DEFAULT);
  const hid_t space =
      a.extents.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(a.extents.size()), a.extents.data(), nullptr);
  const hid_t set = H5Dcreate2(file, name.c_str(), *a.type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  a.bytes.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)) * H5Tget_size(*a.type));
  if (!a.bytes.empty()) H5Dwrite(set, *a.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, a.bytes.data());
  H5Sclose(space);
  H5Dclose(set);
}

void replace_attribute(hid_t file, const std::string& name, hid_t type, hsize_t count, const void* value) {
  H5Adelete(file, name.c_str());
  const hid_t space = count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr);
  const hid_t attribute = H5Acreate2(file, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(attribute, type, value);
  H5Aclose(attribute);
  H5Sclose(space);
}

enum Alteration : std::uint8_t {
  value,
  removal,
  extent,
  type,
  rank,
  integer_attribute,
  real_attribute,
  text_attribute,
  no_attribute,
  count
};

void alter(hid_t file, Recipe& recipe) {
  const auto what = static_cast<Alteration>(recipe.byte() % Alteration::count);
  const std::vector<std::string> names = what < integer_attribute ? dataset_names(file) : attribute_names(file);
  if (names.empty()) return;
  const std::string& name = names[recipe.byte() % names.size()];
  switch (what) {
    case value: {
      Array a = read_array(file, name);
      const std::size_t width = H5Tget_size(*a.type), elements = a.bytes.size() / width, at = recipe.word(), which = recipe.byte();
      if (elements == 0) break;
      unsigned char* const target = a.bytes.data() + at % elements * width;
      const std::size_t real_bytes = sizeof(double);
      if (name == "particle_records") {  // bytes that hold doubles
        const double x = special_reals[which % special_reals.size()];
        std::memcpy(a.bytes.data() + at % (a.bytes.size() / real_bytes) * real_bytes, &x, real_bytes);
      } else if (H5Tget_class(*a.type) == H5T_FLOAT) {
        const double x = special_reals[which % special_reals.size()];
        const auto narrow = static_cast<float>(x);
        width == real_bytes ? std::memcpy(target, &x, width) : std::memcpy(target, &narrow, std::min(width, sizeof narrow));
      } else {
        const std::int64_t x = special_integers[which % special_integers.size()];
        std::memcpy(target, &x, width);
      }
      replace_array(file, name, std::move(a));
      break;
    }
    case removal: H5Ldelete(file, name.c_str(), H5P_DEFAULT); break;
    case extent: {
      Array a = read_array(file, name);
      if (!a.extents.empty()) a.extents[recipe.byte() % a.extents.size()] = special_extents[recipe.byte() % special_extents.size()];
      replace_array(file, name, std::move(a));
      break;
    }
    case type: {
      Array a = read_array(file, name);
      a.type = owned(H5Tcopy(some_type(recipe.byte())));
      replace_array(file, name, std::move(a));
      break;
    }
    case rank: {
      Array a = read_array(file, name);
      a.extents.assign(recipe.byte() % 4, special_extents[recipe.byte() % special_extents.size()]);
      replace_array(file, name, std::move(a));
      break;
    }
    case integer_attribute: {
      const std::size_t which = recipe.byte(), n = 1 + recipe.byte() % 2;
      const std::vector<std::int64_t> x(n, special_integers[which % special_integers.size()]);
      replace_attribute(file, name, H5T_NATIVE_INT64, n, x.data());
      break;
    }
    case real_attribute: {
      const double x = special_reals[recipe.byte() % special_reals.size()];
      replace_attribute(file, name, H5T_NATIVE_DOUBLE, 1, &x);
      break;
    }
    case text_attribute: {
      const hid_t fixed = H5Tcopy(H5T_C_S1);
      H5Tset_size(fixed, recipe.byte() % 2 == 0 ? 4 : H5T_VARIABLE);
      const char* const text = "abc\n";
      replace_attribute(file, name, fixed, 1, H5Tis_variable_str(fixed) > 0 ? static_cast<const void*>(&text) : text);
      H5Tclose(fixed);
      break;
    }
    case no_attribute: H5Adelete(file, name.c_str()); break;
    case count: break;
  }
}

std::string altered(const std::string& original, Recipe& recipe) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  constexpr std::size_t increment = std::size_t{64} << 10;
  H5Pset_fapl_core(access, increment, false);
  std::string image = original;
  H5Pset_file_image(access, image.data(), image.size());
  const hid_t file = H5Fopen("altered", H5F_ACC_RDWR, access);
  H5Pclose(access);
  require(file >= 0, "the original opens");
  constexpr int most = 8;
  for (int i = 0; i < most && recipe.more(); ++i) alter(file, recipe);
  H5Fflush(file, H5F_SCOPE_GLOBAL);
  image.resize(static_cast<std::size_t>(H5Fget_file_image(file, nullptr, 0)));
  H5Fget_file_image(file, image.data(), image.size());
  H5Fclose(file);
  return image;
}

std::string sealed(const std::string& image) {
  return image + fmt::format("MPMCRC32{:08x}", crc32_z(0, reinterpret_cast<const Bytef*>(image.data()), image.size()));
}

/// What was accepted can be measured, and computed on.
void use_checkpoint(const std::filesystem::path& path) {
  State state(cell_size);
  RunProgress progress;
  Arrays observed;
  read_checkpoint(path, small_case(), state, progress, observed);
  require(std::isfinite(state.time), "a time");
  ObserverList observers = testing::impact_observers(geometry(), {.velocity = 10.0});
  observers.load(observed, progress.samples);
  const Summary end = observers.summary(&state, &progress);
  (void)observers.results(end);
  const CaseScene scene = make_scene(small_case());
  (void)particle_table(state, scene);
  (void)step(state, scene, 1e-4);
}

void use_snapshot(const Snapshot& s) {
  const ParticleTable& p = s.particles;
  const std::size_t n = p.size();
  require(p.position.size() == 3 * n && p.velocity.size() == 3 * n && p.stress.size() == 6 * n, "columns of one length");
  for (std::size_t i = 0; i < n; ++i) {
    require(i == 0 || p.id[i] > p.id[i - 1], "particles in the order of their numbers, each once");
    require(std::isfinite(p.position[3 * i]) && p.volume_ratio[i] > 0.0 && p.volume[i] > 0.0, "numbers that mean something");
  }
  ObserverList observers = testing::impact_observers(geometry(), {.velocity = 10.0});
  (void)observers.sample(s, [](const Column&) { return 0.0; });
}

}  // namespace

void state_file(Bytes bytes) {
  static const Originals originals;
  Recipe recipe(bytes);
  const std::size_t kind = recipe.byte() % originals.images.size();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const std::string content = sealed(altered(originals.images[kind], recipe));
  const MemoryFile file({reinterpret_cast<const std::uint8_t*>(content.data()), content.size()});
  try {
    switch (kind) {
      case 0: use_checkpoint(file.path()); break;
      case 1: use_snapshot(read_snapshot(file.path(), SnapshotKind::frame)); break;
      default: use_snapshot(read_snapshot(file.path(), SnapshotKind::final)); break;
    }
  } catch (const IoError&) {
  } catch (const UnstableError&) {  // found in the step, not in the file
  } catch (const ConfigError&) {    // a series without a steady span
  }
}

}  // namespace mpm::fuzz
