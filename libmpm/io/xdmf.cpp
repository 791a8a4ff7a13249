#include "libmpm/io/xdmf.hpp"

#include <fmt/format.h>

#include <span>
#include <string_view>
#include <utility>

#include "libmpm/io/atomic_file.hpp"

namespace mpm {
namespace {

struct Field {
  std::string_view name, dataset, number_type;
  int precision;   ///< bytes
  int components;  ///< 1 or 3
};

constexpr Field fields[] = {
    {"position", "position_m", "Float", 8, 3},   {"velocity", "velocity_m_s", "Float", 4, 3},
    {"pressure", "pressure_pa", "Float", 4, 1},  {"stress_xx", "stress_xx_pa", "Float", 4, 1},
    {"density", "density_kg_m3", "Float", 4, 1}, {"volume_ratio", "volume_ratio", "Float", 8, 1},
    {"internal", "internal", "Float", 4, 1},     {"id", "id", "Int", 8, 1},  // identity numbers are below 2^52
};

std::string data_item(const Field& field, const FrameEntry& frame, const std::string& file) {
  const std::string dimensions =
      field.components == 1 ? fmt::format("{}", frame.particles) : fmt::format("{} {}", frame.particles, field.components);
  return fmt::format("<DataItem Format=\"HDF\" NumberType=\"{}\" Precision=\"{}\" Dimensions=\"{}\">{}:/{}</DataItem>", field.number_type,
                     field.precision, dimensions, file, field.dataset);
}

/// Writes DIR/frames.xdmf: a temporal collection with one Polyvertex grid a frame, geometry position_m, and the fields as attributes.
/// Frames must be in the order of time.
void write_xdmf(const std::filesystem::path& directory, std::span<const FrameEntry> frames) {
  std::string xml =
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"particles\" GridType=\"Collection\" "
      "CollectionType=\"Temporal\">\n";
  for (const FrameEntry& frame : frames) {
    const std::string file = frame_path("", frame.index).generic_string();
    xml += fmt::format("<Grid Name=\"{:05d}\" GridType=\"Uniform\">\n<Time Value=\"{}\"/>\n", frame.index, frame.time);
    xml += fmt::format("<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\" NodesPerElement=\"1\">{}</Topology>\n",
                       frame.particles, data_item({"vertex", "vertex", "Int", 4, 1}, frame, file));
    xml += fmt::format("<Geometry GeometryType=\"XYZ\">{}</Geometry>\n", data_item(fields[0], frame, file));
    for (const Field& field : fields) {
      xml += fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">{}</Attribute>\n", field.name,
                         field.components == 1 ? "Scalar" : "Vector", data_item(field, frame, file));
    }
    xml += "</Grid>\n";
  }
  xml += "</Grid>\n</Domain>\n</Xdmf>\n";
  write_file(directory / "frames.xdmf", xml);
}

}  // namespace

FrameSeries::FrameSeries(std::filesystem::path directory, std::vector<FrameEntry> frames, int next)
    : directory_(std::move(directory)), frames_(std::move(frames)), next_(next) {}

FrameSeries FrameSeries::create(std::filesystem::path directory) {
  remove_file(directory / "frames.xdmf");  // the index before the files that it refers to
  for (const int index : frame_numbers(directory)) remove_file(frame_path(directory, index));
  make_directory(directory / "frames");
  remove_leftovers(directory / "frames");
  return FrameSeries(std::move(directory), {}, 0);
}

FrameSeries FrameSeries::resume(std::filesystem::path directory, int next, const std::function<void(const std::string&)>& damaged) {
  make_directory(directory / "frames");
  remove_leftovers(directory / "frames");
  std::vector<FrameEntry> frames;
  std::vector<int> later;
  for (const int index : frame_numbers(directory)) {
    if (index >= next) {
      later.push_back(index);
      continue;
    }
    try {
      frames.push_back(read_frame_entry(directory, index));
    } catch (const IoError& error) {
      if (damaged) damaged(error.what());
    }
  }
  write_xdmf(directory, frames);
  for (const int index : later) remove_file(frame_path(directory, index));
  return FrameSeries(std::move(directory), std::move(frames), next);
}

void FrameSeries::append(const SnapshotInfo& info, const std::function<void(SnapshotWriter&)>& fill) {
  SnapshotWriter file = frame_writer(directory_, next_, info);
  fill(file);
  frames_.push_back({next_, info.time, file.particles()});
  ++next_;
  write_xdmf(directory_, frames_);
}

}  // namespace mpm
