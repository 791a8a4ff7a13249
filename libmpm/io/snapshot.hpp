#pragma once
/// States on disk: frames/NNNNN.h5 for pictures and for recomputing measurements, final.h5 for further use.
///
/// Both hold one row a particle, ordered by identity number, so that they do not depend on the number of threads.
///
/// | dataset | frame | final | meaning |
/// |---|---|---|---|
/// | id | uint64 | uint64 | identity number |
/// | position_m (N,3) | float64 | float64 | x |
/// | velocity_m_s (N,3) | float32 | float64 | v |
/// | velocity_gradient_1_s (N,3,3) | | float64 | C, [p,i,j] = dv_i/dx_j |
/// | kirchhoff_stress_pa (N,6) | float64 | float64 | tau, tension positive: xx yy zz xy xz yz |
/// | volume_ratio | float64 | float64 | J = det F |
/// | reference_volume_m3 | float64 | float64 | V_0; mass = reference_density_kg_m3 V_0 |
/// | internal | float32 | float64 | the law's internal variable |
/// | pressure_pa | float32 | | Cauchy, p = -tr(tau)/(3 J), compression positive |
/// | stress_xx_pa | float32 | | Cauchy, sigma_xx = tau_xx / J, tension positive |
/// | density_kg_m3 | float32 | | rho_0 / J |
/// | vertex | int32 | | 0 ... N-1: the cells of frames.xdmf; without them ParaView's Xdmf3 reader finds points but no cell to draw |
///
/// In frames all data that `mpm post` needs have double precision, so that it computes the same numbers as the run; data for pictures have
/// single precision. A frame takes 128 bytes a particle.
/// Attributes of both: format_version, kind, time_s, step, case_hash, version, reference_density_kg_m3, mirror_x, mirror_y,
/// precision ("double" or "single", that of the computation).

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/core/grid.hpp"

namespace mpm {

struct Scene;
struct State;

/// The places of all particles by ascending identity number, 16 bytes for each. The grid must not change while this object is used.
class ParticleOrder {
 public:
  /// Of this rank's particles. @param keep  selects particles; empty: all
  explicit ParticleOrder(const Grid& grid, const std::function<bool(const Particle&)>& keep = {}) : grid_(grid) {
    std::size_t most = 0;
    for (const auto b : grid.occupied_blocks()) most += static_cast<std::size_t>(grid.block(b).particles.count());
    order_.reserve(most);
    for (const auto b : grid.occupied_blocks()) {
      const ParticleBin& bin = grid.block(b).particles;
      for (std::int32_t s = 0; s < bin.count(); ++s) {
        const Particle p = bin[s];
        if (!keep || keep(p)) order_.push_back({p.id, b, s});
      }
    }
    std::ranges::sort(order_, {}, &Place::id);
  }

  [[nodiscard]] std::size_t size() const { return order_.size(); }              ///< particles
  [[nodiscard]] std::uint64_t id(std::size_t i) const { return order_[i].id; }  ///< of the i-th
  [[nodiscard]] Particle operator[](std::size_t i) const {                      ///< the i-th
    return grid_.block(order_[i].block).particles[order_[i].slot];
  }
  /// Place of the first particle whose number is not below this.
  [[nodiscard]] std::size_t first_from(std::uint64_t id) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(order_, id, {}, &Place::id) - order_.begin());
  }

 private:
  struct Place {
    std::uint64_t id;
    std::int32_t block, slot;
  };
  const Grid& grid_;
  std::vector<Place> order_;
};

/// Particles by columns, one entry a particle in the order of the identity numbers. Units and measures as in core/particle.hpp.
struct ParticleTable {
  std::vector<std::uint64_t> id;     ///< N, identity numbers, ascending
  std::vector<double> position;      ///< 3 N, m
  std::vector<double> velocity;      ///< 3 N, m/s
  std::vector<double> affine;        ///< 9 N, 1/s, by columns: [9 p + 3 j + i] = dv_i/dx_j; empty after reading a frame
  std::vector<double> stress;        ///< 6 N, Pa, Kirchhoff tau, tension positive: xx yy zz xy xz yz
  std::vector<double> internal;      ///< N
  std::vector<double> volume_ratio;  ///< N, J
  std::vector<double> volume;        ///< N, reference volume V_0, m^3

  [[nodiscard]] std::size_t size() const { return id.size(); }  ///< N
};

/// Particles by columns. @param particles  by ascending identity number
ParticleTable particle_table(std::span<const Particle> particles, const Scene& scene);
/// The particles of a state in the order of their identity numbers; with several ranks those of this one.
/// @param keep  selects particles; empty: all
ParticleTable particle_table(const State& state, const Scene& scene, const std::function<bool(const Particle&)>& keep = {});

/// Origin of a state: case, time, program, precision.
struct SnapshotInfo {
  double time = 0.0;                                  ///< s
  std::int64_t step = 0;                              ///< steps done since t = 0
  std::string case_hash;                              ///< case_hash_text of driver/case_file.hpp
  std::string version;                                ///< of the program that wrote the file
  double reference_density = 0.0;                     ///< rho_0, kg/m^3
  bool mirror_x = false;                              ///< only x >= 0 is computed and stored
  bool mirror_y = false;                              ///< only y >= 0 is computed and stored
  Precision precision = Precision::double_precision;  ///< in which it was computed
};

/// Content of a frame or of a final state.
struct Snapshot {
  SnapshotInfo info;        ///< the attributes
  ParticleTable particles;  ///< the datasets
};

/// DIR/frames/NNNNN.h5
std::filesystem::path frame_path(const std::filesystem::path& directory, int index);

/// Kind of file, which determines columns and precision.
enum class SnapshotKind : std::uint8_t { frame, final };

/// Writes a frame or a final state piece by piece: memory holds one piece at a time. With several ranks each writes some of the rows
/// (joint_file.hpp). Errors of a disk or of the memory are kept until commit().
class SnapshotWriter {
 public:
  /// Writes nothing before begin().
  SnapshotWriter(SnapshotKind kind, std::filesystem::path path, SnapshotInfo info);
  /// On a rank other than the first: what is written follows from what the first begins.
  SnapshotWriter();
  /// Removes the file if it was not finished.
  ~SnapshotWriter();

  /// Begins the file. @param particles  of all pieces and ranks. @param first  row of the first of this rank. @param ranks  those that
  /// write it
  void begin(std::size_t particles, std::size_t first = 0, Ranks& ranks = one_rank());
  /// The next particles.
  void append(const ParticleTable& piece);
  /// The next particles, by rising identity number.
  void append(std::span<const Particle> piece, const Scene& scene);
  /// All are there: the file gets its name. @throws what failed since begin(): IoError; also if columns differ in length
  void commit();
  /// The whole file at once. @throws as commit()
  void write(const ParticleTable& particles);
  [[nodiscard]] std::size_t particles() const;  ///< in the file, of all ranks

 private:
  struct File;
  std::unique_ptr<File> file_;
};

/// Of frame `index` of the run directory. Creates DIR/frames if needed, but not DIR, so that a directory that was moved during a run
/// is not created again. @throws IoError
SnapshotWriter frame_writer(const std::filesystem::path& directory, int index, const SnapshotInfo& info);

/// @throws IoError if the file is missing, damaged, of another kind or version
Snapshot read_snapshot(const std::filesystem::path& path, SnapshotKind kind);

/// Number, time and size of a frame.
struct FrameEntry {
  int index = 0;              ///< NNNNN in the name of its file
  double time = 0.0;          ///< s
  std::size_t particles = 0;  ///< N
};

/// Numbers of the frames DIR/frames/NNNNN.h5 in ascending order; none if there is no DIR/frames. Other files there are ignored.
std::vector<int> frame_numbers(const std::filesystem::path& directory);

/// Reads a frame's file once (its checksum). @throws IoError as read_snapshot
FrameEntry read_frame_entry(const std::filesystem::path& directory, int index);

}  // namespace mpm
