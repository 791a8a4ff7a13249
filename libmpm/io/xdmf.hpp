#pragma once
/// frames.xdmf: the frames of a run as one time-dependent data set (XDMF 3, xdmf.org), opened by ParaView and VisIt. The file only refers
/// to the arrays in frames/NNNNN.h5, by relative paths: a run directory can be moved.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "libmpm/io/snapshot.hpp"

namespace mpm {

/// Writes the frames of a run one after the other and keeps frames.xdmf up to date, so that both can be read at any time.
class FrameSeries {
 public:
  /// A new series: frames that an earlier run left in the directory are removed.
  static FrameSeries create(std::filesystem::path directory);
  /// Continues with frame number `next`: that one and later ones are removed. Earlier ones that
  /// cannot be read stay, but frames.xdmf does not refer to them.
  /// @param damaged called with the reason for each of these
  static FrameSeries resume(std::filesystem::path directory, int next, const std::function<void(const std::string&)>& damaged = {});

  /// Writes the next frame, then frames.xdmf. @param fill  begins the frame's file, writes its particles and commits it
  void append(const SnapshotInfo& info, const std::function<void(SnapshotWriter&)>& fill);

 private:
  FrameSeries(std::filesystem::path directory, std::vector<FrameEntry> frames, int next);

  std::filesystem::path directory_;
  std::vector<FrameEntry> frames_;
  int next_;  ///< number of the next frame
};

}  // namespace mpm
