#include "libmpm/driver/checkpoint.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <limits>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/hdf5.hpp"
#include "support/io_error.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Checkpoint : public ::testing::Test {
 protected:
  /// An avalanche under way: snow has entered and left, slots are in an order that only the past explains.
  Checkpoint() : c(testing::small_avalanche(8.0)), scene(make_scene(c)), state(make_state(c, scene)), path(directory / "checkpoint.h5") {
    advance(state, scene, 0.4);
    progress = {21, 123456789012345, 2304, 12.5, 11.25};
    observed = {{"series.time_s", {0.0, 0.02, 0.04}},
                {"series.pressure_height_m", {std::nan(""), 1.25, std::nan("")}},  // unknown at two of the samples
                {"pressure_profile.pressure_pa", {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}},
                {"empty.nothing_yet", {}}};
  }
  void write() { write_checkpoint(path, c, state, progress, observed); }
  /// Message with which reading is refused; nothing is changed then.
  std::string refusal(const Case& now, ExitCode code = ExitCode::io) {
    State fresh(0.25);
    RunProgress p;
    Arrays o;
    try {
      read_checkpoint(path, now, fresh, p, o);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code);
      EXPECT_EQ(fresh.grid.particle_count(), 0U);
      EXPECT_EQ(fresh.step, 0U);
      EXPECT_EQ(p.samples, 0U);
      EXPECT_TRUE(o.empty());
      return error.what();
    }
    ADD_FAILURE() << "not refused";
    return {};
  }
  std::string refusal() { return refusal(c); }
  /// What a folder gives.
  struct Resumed {
    std::uint64_t samples = 0;
    std::string message;
  };
  Resumed resumed(const AcceptCheckpoint& acceptable = [](const State&, const RunProgress&, const Arrays&) {}) {
    State fresh(0.25);
    RunProgress p;
    Arrays accepted;
    Resumed result;
    result.message = resume_from_checkpoint(directory.path(), c, fresh, p, [&](const State& s, const RunProgress& at, const Arrays& o) {
      acceptable(s, at, o);
      accepted = o;
    });
    result.samples = p.samples;
    EXPECT_TRUE(testing::same_bytes(testing::stored_particles(fresh.grid), testing::stored_particles(state.grid)));
    EXPECT_EQ(accepted.size(), observed.size());
    return result;
  }
  /// Two checkpoints one after the other, of 21 and 22 samples, as a run writes them.
  void write_two() {
    const auto older = directory / previous_checkpoint_file;
    write_checkpoint(path, c, state, progress, observed, older);
    ++progress.samples;
    write_checkpoint(path, c, state, progress, observed, older);
  }
  testing::TemporaryDirectory directory;
  Case c;
  CaseScene scene;
  State state;
  RunProgress progress;
  Arrays observed;
  std::filesystem::path path;
};

/// Equal, where unknown (NaN) equals unknown.
void expect_same(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i])));
}

TEST_F(Checkpoint, GivesBackEverythingToTheBit) {
  ASSERT_GT(state.entered.count, 0U);
  ASSERT_GT(state.left.count, 0U);
  write();
  State read(0.25);
  RunProgress p;
  Arrays o;
  read_checkpoint(path, c, read, p, o);
  EXPECT_TRUE(testing::same_bytes(testing::stored_particles(read.grid), testing::stored_particles(state.grid)));
  EXPECT_EQ(read.time, state.time);
  EXPECT_EQ(read.step, state.step);
  EXPECT_EQ(read.next_id, state.next_id);
  EXPECT_EQ(read.source_count, state.source_count);
  EXPECT_EQ(read.max_speed, state.max_speed);
  for (const auto& [a, b] : {std::pair{&read.entered, &state.entered}, std::pair{&read.left, &state.left}}) {
    EXPECT_EQ(a->count, b->count);
    EXPECT_EQ(a->through_x_max, b->through_x_max);
    EXPECT_EQ(a->mass, b->mass);
    EXPECT_EQ(a->momentum, b->momentum);
  }
  EXPECT_EQ(p.samples, progress.samples);
  EXPECT_EQ(p.particle_steps, progress.particle_steps);
  EXPECT_EQ(p.initial_particles, progress.initial_particles);
  EXPECT_EQ(p.wall_time, progress.wall_time);
  EXPECT_EQ(p.step_time, progress.step_time);
  ASSERT_EQ(o.size(), observed.size());
  for (const auto& [name, values] : observed) expect_same(o.at(name), values);
}

TEST_F(Checkpoint, RefusesArraysThatNoObserverOwns) {
  observed["cells"] = {1.0};  // would be mistaken for its own
  EXPECT_THROW(write(), Error);
}

TEST_F(Checkpoint, GoesOnToTheSameBits) {
  write();
  State read(0.25);
  read_checkpoint(path, c, read, progress, observed);
  for (int n = 0; n < 50; ++n) {
    const double dt = stable_time_step(state, scene);
    ASSERT_EQ(stable_time_step(read, scene), dt);
    step(state, scene, dt);
    step(read, scene, dt);
  }
  EXPECT_TRUE(testing::same_bytes(testing::stored_particles(read.grid), testing::stored_particles(state.grid)));
}

TEST_F(Checkpoint, OfAnEmptyStateIsOneToo) {
  const State nothing(0.25);
  write_checkpoint(path, c, nothing, {}, {});
  State read(0.25);
  RunProgress p;
  Arrays o;
  read_checkpoint(path, c, read, p, o);
  EXPECT_EQ(read.grid.particle_count(), 0U);
  EXPECT_TRUE(o.empty());
}

TEST_F(Checkpoint, OfAnotherCaseIsRefusedWithWhatDiffers) {
  write();
  Case edited = c;
  edited.numerics.cfl = 0.3;
  edited.obstacle->friction = 0.5;
  edited.output.duration = 77.0;  // a longer run of the same case
  const std::string message = refusal(edited, ExitCode::usage);
  for (const std::string& part :
       {path.string(), std::string("numerics.cfl was 0.4, is 0.3"), std::string("obstacle.friction was"), std::string("--out")})
    EXPECT_THAT(message, HasSubstr(part));
  EXPECT_THAT(message, Not(HasSubstr("duration")));
  edited = c;
  edited.output.duration = 77.0;
  edited.title = "another title";
  State fresh(0.25);
  EXPECT_NO_THROW(read_checkpoint(path, edited, fresh, progress, observed));
}

TEST_F(Checkpoint, NewestIsGoneOnFrom) {
  write_two();
  const Resumed r = resumed();
  EXPECT_EQ(r.samples, 22U);
  EXPECT_EQ(r.message, "");
}

TEST_F(Checkpoint, PreviousIsGoneOnFromWhereTheNewestCannotBe) {
  const auto refused = directory / refused_checkpoint_file;
  const auto expect_previous = [&](const std::string& reason, bool kept = true) {
    SCOPED_TRACE(reason);
    const Resumed r = resumed();
    EXPECT_EQ(r.samples + 1, progress.samples);
    EXPECT_THAT(r.message, HasSubstr(reason));
    EXPECT_THAT(r.message, HasSubstr(previous_checkpoint_file));
    EXPECT_FALSE(std::filesystem::exists(path));  // or it would become the previous one of the next, and push out the good one
    EXPECT_EQ(std::filesystem::exists(refused), kept);
    std::filesystem::remove(refused);
  };
  write_two();
  std::filesystem::resize_file(path, 1000);
  expect_previous("cut off");

  write_two();
  std::string bytes = read_file(path);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  write_file(path, bytes);
  expect_previous("checksum");

  write_two();
  write_file(path, "To whom it may concern: this file is a letter.");
  expect_previous("written by another program");

  write_two();
  Case other = c;
  other.numerics.cfl = 0.1;
  write_checkpoint(path, other, state, progress, observed);
  expect_previous("numerics.cfl was 0.1");

  write_two();
  std::filesystem::remove(path);  // killed between the two renamings
  expect_previous("does not exist", false);

  write_two();
  const auto not_the_newest = [&](const State&, const RunProgress& p, const Arrays&) {
    if (p.samples == progress.samples) throw IoError("series.csv has no such row");
  };
  EXPECT_THAT(resumed(not_the_newest).message, HasSubstr("no such row"));
}

TEST_F(Checkpoint, WithoutAGoodOneEveryReasonIsGivenAndNothingIsTouched) {
  write_two();
  std::filesystem::resize_file(path, 1000);
  write_file(directory / previous_checkpoint_file, "no checkpoint either");
  const std::string message = testing::io_error_of([&] { (void)resumed(); });
  EXPECT_THAT(message, HasSubstr(path.string()));
  EXPECT_THAT(message, HasSubstr(previous_checkpoint_file));
  EXPECT_THAT(message, HasSubstr("--force instead of --resume"));
  EXPECT_TRUE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::exists(directory / refused_checkpoint_file));
  Case edited = c;
  write_two();
  edited.numerics.cfl = 0.3;
  State fresh(0.25);
  EXPECT_THROW(
      (void)resume_from_checkpoint(directory.path(), edited, fresh, progress, [](const State&, const RunProgress&, const Arrays&) {}),
      ConfigError);
}

TEST_F(Checkpoint, WithAParticleThatIsThereTwiceIsRefused) {
  State doubled(0.25);
  for (const std::uint64_t id : {0U, 1U, 1U}) {
    Particle p{};
    p.id = id;
    p.position[0] = 0.3 * static_cast<double>(doubled.grid.particle_count());
    p.volume = 1e-3;
    doubled.grid.insert(p);
  }
  doubled.grid.refresh();
  doubled.next_id = 2;
  write_checkpoint(path, c, doubled, progress, observed);
  EXPECT_THAT(refusal(), HasSubstr("particle 1 is there twice"));
}

TEST_F(Checkpoint, ThatIsMissingTruncatedOrAlteredIsRefused) {
  EXPECT_THAT(refusal(), HasSubstr(path.string()));
  write();
  const auto size = std::filesystem::file_size(path);
  std::vector<char> bytes(size);
  std::ifstream(path, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(size));
  for (const std::size_t kept : {std::size_t{0}, std::size_t{7}, size / 2, size - 1}) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(kept));
    EXPECT_THAT(refusal(), HasSubstr(path.string())) << kept;
  }
  bytes[size / 2] = static_cast<char>(bytes[size / 2] ^ 1);
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(size));
  EXPECT_THAT(refusal(), HasSubstr(path.string()));
}

TEST_F(Checkpoint, WhoseIdentityNumbersNoRunGaveIsRefused) {
  for (const std::uint64_t next : {std::uint64_t{1}, std::numeric_limits<std::uint64_t>::max()}) {
    state.next_id = next;  // its checksum is right
    write();
    EXPECT_THAT(refusal(), HasSubstr("number"));
  }
}

TEST_F(Checkpoint, OfAnotherKindOrVersionIsRefused) {
  const auto file_with = [&](const std::string& kind, std::int64_t format, const std::string& version = std::string(build_info().version)) {
    hdf5::Writer file(path);
    file.attribute("kind", kind);
    file.attribute("format_version", format);
    file.attribute("version", version);
    file.attribute("case_hash", case_hash_text(c));
    file.commit();
  };
  file_with("something else", checkpoint_format_version);
  EXPECT_THAT(refusal(), HasSubstr("not a checkpoint"));
  file_with("libmpm checkpoint", checkpoint_format_version + 1);
  EXPECT_THAT(refusal(), HasSubstr("checkpoint format 6, this program reads 5"));
  file_with("libmpm checkpoint", 2);
  EXPECT_THAT(refusal(), HasSubstr("checkpoint format 2, this program reads 5; go on with the version of the program that wrote it"));
  file_with("libmpm checkpoint", checkpoint_format_version, "9.9.9");
  EXPECT_THAT(refusal(), HasSubstr("a checkpoint of version 9.9.9, this program is "));
  file_with("libmpm checkpoint", checkpoint_format_version);  // its datasets are missing
  EXPECT_THAT(refusal(), HasSubstr(path.string()));
}

}  // namespace
}  // namespace mpm
