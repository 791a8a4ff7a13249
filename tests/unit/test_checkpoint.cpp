#include "mpm/io/checkpoint.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "mpm/error.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/hdf5.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using ::testing::HasSubstr;

class Checkpoint : public ::testing::Test {
 protected:
  /// An avalanche under way: snow has entered and left, slots are in an order that only the past explains.
  Checkpoint() : c(testing::small_avalanche(8.0)), scene(make_scene(c)), state(make_state(c, scene)), path(directory / "checkpoint.h5") {
    advance(state, scene, 0.4);
    progress = {21, 123456789012345, 2304, 12.5, 11.25};
    for (int i = 0; i < 3; ++i) {
      ImpactFrame frame;
      frame.runup = 1.5 + i;
      if (i == 1) frame.pressure_height = 1.25;  // unknown in the others
      frame.pressure.assign(5, 100.0 * i);
      series.append(0.02 * i, frame, Vec3(i, 2.0, 3.0), i == 0 ? Vec3(Vec3::Constant(std::nan(""))) : Vec3(4.0, 5.0, i));
    }
  }
  void write() { write_checkpoint(path, "abc", state, progress, series); }
  std::string refusal(const std::string& hash = "abc") {
    State fresh(0.25);
    RunProgress p;
    ImpactSeries s;
    try {
      read_checkpoint(path, hash, fresh, p, s);
    } catch (const IoError& error) {
      EXPECT_EQ(error.code(), ExitCode::io);
      return error.what();
    }
    ADD_FAILURE() << "not refused";
    return {};
  }
  testing::TemporaryDirectory directory;
  Case c;
  Scene scene;
  State state;
  RunProgress progress;
  ImpactSeries series;
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
  ImpactSeries s;
  read_checkpoint(path, "abc", read, p, s);
  EXPECT_TRUE(testing::same_bytes(testing::stored_particles(read.grid), testing::stored_particles(state.grid)));
  EXPECT_EQ(read.time, state.time);
  EXPECT_EQ(read.step, state.step);
  EXPECT_EQ(read.next_id, state.next_id);
  EXPECT_EQ(read.fed_layers, state.fed_layers);
  EXPECT_EQ(read.max_speed, state.max_speed);
  for (const auto& [a, b] : {std::pair{&read.entered, &state.entered}, std::pair{&read.left, &state.left}}) {
    EXPECT_EQ(a->count, b->count);
    EXPECT_EQ(a->downstream, b->downstream);
    EXPECT_EQ(a->mass, b->mass);
    EXPECT_EQ(a->momentum, b->momentum);
  }
  EXPECT_EQ(p.samples, progress.samples);
  EXPECT_EQ(p.particle_steps, progress.particle_steps);
  EXPECT_EQ(p.initial_particles, progress.initial_particles);
  EXPECT_EQ(p.wall_time, progress.wall_time);
  EXPECT_EQ(p.step_time, progress.step_time);
  expect_same(s.time, series.time);
  expect_same(s.runup, series.runup);
  expect_same(s.runup_p99, series.runup_p99);
  expect_same(s.pressure_height, series.pressure_height);
  expect_same(s.impact_pressure, series.impact_pressure);
  expect_same(s.compaction, series.compaction);
  expect_same(s.profile_pressure, series.profile_pressure);
  EXPECT_EQ(s.profile_bins, series.profile_bins);
  ASSERT_EQ(s.force.size(), series.force.size());
  ASSERT_EQ(s.moment.size(), series.moment.size());
  for (std::size_t i = 0; i < s.force.size(); ++i) {
    EXPECT_EQ(s.force[i], series.force[i]);
    expect_same({s.moment[i].begin(), s.moment[i].end()}, {series.moment[i].begin(), series.moment[i].end()});
  }
}

TEST_F(Checkpoint, GoesOnToTheSameBits) {
  write();
  State read(0.25);
  read_checkpoint(path, "abc", read, progress, series);
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
  write_checkpoint(path, "abc", nothing, {}, {});
  State read(0.25);
  RunProgress p;
  ImpactSeries s;
  read_checkpoint(path, "abc", read, p, s);
  EXPECT_EQ(read.grid.particle_count(), 0U);
  EXPECT_EQ(s.size(), 0U);
}

TEST_F(Checkpoint, OfAnotherCaseIsRefused) {
  write();
  const std::string message = refusal("def");
  EXPECT_THAT(message, HasSubstr(path.string()));
  EXPECT_THAT(message, HasSubstr("abc"));
  EXPECT_THAT(message, HasSubstr("def"));
  EXPECT_THAT(message, HasSubstr("--out"));
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

TEST_F(Checkpoint, OfAnotherKindOrVersionIsRefused) {
  const auto file_with = [&](const std::string& kind, std::int64_t version) {
    hdf5::Writer file;
    file.attribute("kind", kind);
    file.attribute("format_version", version);
    file.attribute("case_hash", std::string("abc"));
    file.save(path);
  };
  file_with("something else", 1);
  EXPECT_THAT(refusal(), HasSubstr("not a checkpoint"));
  file_with("libmpm checkpoint", checkpoint_format_version + 1);
  EXPECT_THAT(refusal(), HasSubstr("checkpoint format 2"));
  file_with("libmpm checkpoint", checkpoint_format_version);  // its datasets are missing
  EXPECT_THAT(refusal(), HasSubstr(path.string()));
}

}  // namespace
}  // namespace mpm
