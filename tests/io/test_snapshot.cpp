#include "libmpm/io/snapshot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/io/xdmf.hpp"
#include "support/sample_particles.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using testing::TemporaryDirectory;

SnapshotInfo info_at(double time) { return {time, 42, "0123456789abcdef", "0.1.0", 300.0, false, true}; }

TEST(Snapshot, FinalStateReadsBackUnchanged) {
  const TemporaryDirectory dir;
  const ParticleTable p = testing::random_particles(500, 1);
  SnapshotWriter(SnapshotKind::final, dir / "final.h5", info_at(1.0 / 3.0)).write(p);
  const Snapshot s = read_snapshot(dir / "final.h5", SnapshotKind::final);
  EXPECT_EQ(s.info.time, 1.0 / 3.0);
  EXPECT_EQ(s.info.step, 42);
  EXPECT_EQ(s.info.case_hash, "0123456789abcdef");
  EXPECT_EQ(s.info.version, "0.1.0");
  EXPECT_EQ(s.info.reference_density, 300.0);
  EXPECT_FALSE(s.info.mirror_x);
  EXPECT_TRUE(s.info.mirror_y);
  EXPECT_EQ(s.particles.id, p.id);
  EXPECT_EQ(s.particles.position, p.position);
  EXPECT_EQ(s.particles.velocity, p.velocity);
  EXPECT_EQ(s.particles.affine, p.affine);
  EXPECT_EQ(s.particles.stress, p.stress);
  EXPECT_EQ(s.particles.internal, p.internal);
  EXPECT_EQ(s.particles.volume_ratio, p.volume_ratio);
  EXPECT_EQ(s.particles.volume, p.volume);
}

TEST(Snapshot, VelocityGradientIsStoredRowByRow) {
  const TemporaryDirectory dir;
  ParticleTable p = testing::random_particles(1, 1);
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) p.affine[static_cast<std::size_t>(3 * j + i)] = 10.0 * i + j;  // dv_i/dx_j = "ij"
  }
  SnapshotWriter(SnapshotKind::final, dir / "final.h5", info_at(0.0)).write(p);
  EXPECT_EQ(hdf5::Reader(dir / "final.h5").dataset<double>("velocity_gradient_1_s", {1, 3, 3}),
            (std::vector<double>{0, 1, 2, 10, 11, 12, 20, 21, 22}));
}

TEST(Snapshot, FrameKeepsWhatMeasurementsNeedInDoubleAndTheRestInSingle) {
  const TemporaryDirectory dir;
  const ParticleTable p = testing::random_particles(500, 2);
  frame_writer(dir.path(), 7, info_at(0.1)).write(p);
  const Snapshot s = read_snapshot(dir / "frames/00007.h5", SnapshotKind::frame);
  EXPECT_EQ(s.info.time, 0.1);
  EXPECT_EQ(s.particles.id, p.id);
  EXPECT_EQ(s.particles.position, p.position);
  EXPECT_EQ(s.particles.stress, p.stress);
  EXPECT_EQ(s.particles.volume_ratio, p.volume_ratio);
  EXPECT_EQ(s.particles.volume, p.volume);
  ASSERT_EQ(s.particles.velocity.size(), p.velocity.size());
  for (std::size_t i = 0; i < p.velocity.size(); ++i) EXPECT_EQ(s.particles.velocity[i], double{static_cast<float>(p.velocity[i])});
  EXPECT_TRUE(s.particles.affine.empty());
}

TEST(Snapshot, DerivedFieldsAreCauchyMeasures) {
  const TemporaryDirectory dir;
  const ParticleTable p = testing::random_particles(100, 3);
  frame_writer(dir.path(), 0, info_at(0.0)).write(p);
  const hdf5::Reader file(frame_path(dir.path(), 0));
  const auto pressure = file.dataset<double>("pressure_pa", {100}), sigma = file.dataset<double>("stress_xx_pa", {100}),
             density = file.dataset<double>("density_kg_m3", {100});
  for (std::size_t i = 0; i < 100; ++i) {
    const double* tau = &p.stress[6 * i];
    const double j = p.volume_ratio[i];
    // Single precision: half a unit in the last of 24 bits.
    const double round_off = 6e-8;
    EXPECT_NEAR(3.0 * pressure[i] * j, -(tau[0] + tau[1] + tau[2]), round_off * 3.0 * std::abs(pressure[i] * j) * 1.01);
    EXPECT_NEAR(sigma[i] * j, tau[0], round_off * std::abs(tau[0]) * 1.01);
    EXPECT_NEAR(density[i] * j, 300.0, round_off * 300.0 * 1.01);
  }
}

/// Rows first .. first + count - 1.
ParticleTable rows(const ParticleTable& p, std::size_t first, std::size_t count) {
  const auto cut = [&](const auto& column, std::size_t components) {
    const auto at = column.begin() + static_cast<std::ptrdiff_t>(first * components);
    return std::decay_t<decltype(column)>(at, at + static_cast<std::ptrdiff_t>(count * components));
  };
  return {cut(p.id, 1),     cut(p.position, 3), cut(p.velocity, 3),     cut(p.affine, 9),
          cut(p.stress, 6), cut(p.internal, 1), cut(p.volume_ratio, 1), cut(p.volume, 1)};
}

TEST(Snapshot, PiecesGiveTheBytesOfTheWhole) {
  const TemporaryDirectory dir;
  const ParticleTable p = testing::random_particles(1000, 4);
  frame_writer(dir.path(), 0, info_at(0.3)).write(p);
  SnapshotWriter(SnapshotKind::final, dir / "final.h5", info_at(0.3)).write(p);
  const auto in_pieces = [&](SnapshotKind kind) {
    SnapshotWriter file(kind, dir / "pieces.h5", info_at(0.3));
    file.begin(1000);
    for (const auto& [first, end] : {std::pair{0U, 1U}, std::pair{1U, 601U}, std::pair{601U, 601U}, std::pair{601U, 1000U}})
      file.append(rows(p, first, end - first));
    EXPECT_EQ(file.particles(), 1000U);
    file.commit();
    return read_file(dir / "pieces.h5");
  };
  EXPECT_EQ(in_pieces(SnapshotKind::frame), read_file(frame_path(dir.path(), 0)));
  EXPECT_EQ(in_pieces(SnapshotKind::final), read_file(dir / "final.h5"));
}

TEST(Snapshot, EmptyStateIsAState) {
  const TemporaryDirectory dir;
  frame_writer(dir.path(), 0, info_at(0.0)).write(ParticleTable{});
  SnapshotWriter(SnapshotKind::final, dir / "final.h5", info_at(0.0)).write(ParticleTable{});
  EXPECT_EQ(read_snapshot(frame_path(dir.path(), 0), SnapshotKind::frame).particles.size(), 0u);
  EXPECT_EQ(read_snapshot(dir / "final.h5", SnapshotKind::final).particles.size(), 0u);
}

TEST(Snapshot, FrameIsNoFinalStateAndColumnsMustMatch) {
  const TemporaryDirectory dir;
  ParticleTable p = testing::random_particles(3, 1);
  frame_writer(dir.path(), 0, info_at(0.0)).write(p);
  EXPECT_THROW((void)read_snapshot(frame_path(dir.path(), 0), SnapshotKind::final), IoError);
  p.stress.pop_back();
  EXPECT_THROW(frame_writer(dir.path(), 1, info_at(0.0)).write(p), IoError);
  EXPECT_THROW(SnapshotWriter(SnapshotKind::final, dir / "final.h5", info_at(0.0)).write(p), IoError);
  EXPECT_EQ(frame_numbers(dir.path()), std::vector<int>{0});
}

TEST(Snapshot, ListsFramesInOrderAndPassesOverOtherFiles) {
  const TemporaryDirectory dir;
  EXPECT_TRUE(frame_numbers(dir.path()).empty());
  for (const int i : {12, 3, 0})
    frame_writer(dir.path(), i, info_at(0.5 * i)).write(testing::random_particles(static_cast<std::size_t>(i), 1));
  for (const char* name : {"notes.txt", "3.h5", "00004.h5.bak", "x0001.h5"}) write_file(dir.path() / "frames" / name, "x");
  EXPECT_EQ(frame_numbers(dir.path()), (std::vector<int>{0, 3, 12}));
  EXPECT_EQ(read_frame_entry(dir.path(), 3).time, 1.5);
  EXPECT_EQ(read_frame_entry(dir.path(), 12).index, 12);
  EXPECT_EQ(read_frame_entry(dir.path(), 12).particles, 12u);
}

TEST(FrameSeries, ResumedSeriesEqualsOneThatWasNeverStopped) {
  const TemporaryDirectory whole, stopped;
  const auto frame = [](FrameSeries& s, int i) {
    testing::append_frame(s, testing::random_particles(20, static_cast<unsigned>(i)), info_at(0.2 * i));
  };
  {
    FrameSeries s = FrameSeries::create(whole.path());
    for (int i = 0; i < 6; ++i) frame(s, i);
  }
  {
    FrameSeries s = FrameSeries::create(stopped.path());
    for (int i = 0; i < 5; ++i) frame(s, i);
  }
  // Killed between frame 5 and the index over it; the checkpoint is of frame 3. What will be written again may be damaged.
  write_file(frame_path(stopped.path(), 4), "damaged");
  frame_writer(stopped.path(), 5, info_at(1.0)).write(testing::random_particles(20, 5));
  {
    FrameSeries s = FrameSeries::resume(stopped.path(), 4);
    EXPECT_EQ(frame_numbers(stopped.path()), (std::vector<int>{0, 1, 2, 3}));
    for (int i = 4; i < 6; ++i) frame(s, i);
  }
  EXPECT_EQ(read_file(stopped / "frames.xdmf"), read_file(whole / "frames.xdmf"));
  EXPECT_EQ(frame_numbers(stopped.path()), frame_numbers(whole.path()));
  for (int i = 0; i < 6; ++i) EXPECT_EQ(read_file(frame_path(stopped.path(), i)), read_file(frame_path(whole.path(), i)));
}

TEST(FrameSeries, ResumedPastADamagedFrameNamesItAndLeavesItOut) {
  const TemporaryDirectory dir;
  {
    FrameSeries s = FrameSeries::create(dir.path());
    for (int i = 0; i < 4; ++i) testing::append_frame(s, testing::random_particles(2, 1), info_at(i));
  }
  std::filesystem::resize_file(frame_path(dir.path(), 1), 100);
  std::filesystem::remove(frame_path(dir.path(), 3));  // the user needed the space
  std::vector<std::string> reasons;
  FrameSeries s = FrameSeries::resume(dir.path(), 4, [&](const std::string& why) { reasons.push_back(why); });
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_NE(reasons[0].find("00001.h5"), std::string::npos) << reasons[0];
  testing::append_frame(s, testing::random_particles(2, 1), info_at(4));
  EXPECT_EQ(frame_numbers(dir.path()), (std::vector<int>{0, 1, 2, 4}));
  const std::string xdmf = read_file(dir / "frames.xdmf");
  EXPECT_NE(xdmf.find("<Xdmf Version=\"3.0\">"), std::string::npos) << "readers such as meshio refuse older versions";
  EXPECT_EQ(xdmf.find("00001.h5"), std::string::npos);
  for (const char* listed : {"00000.h5", "00002.h5", "00004.h5"}) EXPECT_NE(xdmf.find(listed), std::string::npos) << listed;
}

TEST(FrameSeries, NewSeriesRemovesOldFramesAndNothingElse) {
  const TemporaryDirectory dir;
  {
    FrameSeries s = FrameSeries::create(dir.path());
    for (int i = 0; i < 3; ++i) testing::append_frame(s, testing::random_particles(2, 1), info_at(i));
  }
  write_file(dir / "frames/mine.txt", "x");
  FrameSeries s = FrameSeries::create(dir.path());
  EXPECT_TRUE(frame_numbers(dir.path()).empty());
  EXPECT_FALSE(std::filesystem::exists(dir / "frames.xdmf"));
  EXPECT_TRUE(std::filesystem::exists(dir / "frames/mine.txt"));
}

}  // namespace
}  // namespace mpm
