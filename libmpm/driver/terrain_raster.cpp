#include "libmpm/driver/terrain_raster.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "libmpm/base/error.hpp"
#include "libmpm/base/parameter.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/base/types.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

namespace {

constexpr std::size_t most_raster_points = 250'000;      // with ten digits each a third of the largest case file
constexpr std::uintmax_t most_raster_bytes = 8U << 20U;  // as of a case file
constexpr double finest_raster = 0.01;                   // m: a smaller distance of points is one in degrees or kilometres
constexpr double same_place = 1e-3;                      // spacings: rounding of the coordinates in a table

/// Why a text is no raster that a case can have, and the remedy, as the end of a sentence.
struct Unfit : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Words of a text, one after another.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}
  /// Empty at the end.
  std::string_view next() {
    const auto first = rest_.find_first_not_of(blanks);
    if (first == std::string_view::npos) return rest_ = {};
    const auto end = std::min(rest_.find_first_of(blanks, first), rest_.size());
    const std::string_view word = rest_.substr(first, end - first);
    rest_.remove_prefix(end);
    return word;
  }

 private:
  static constexpr const char* blanks = " \t\r\n\f\v";
  std::string_view rest_;
};

/// The numbers of the header, by name. @param word  the first word behind it
struct Header {
  std::map<std::string, double, std::less<>> numbers;
  std::string_view word;

  explicit Header(Words& words) {
    static constexpr const char* known[] = {"ncols",     "nrows",    "xllcenter", "xllcorner", "yllcenter",
                                            "yllcorner", "cellsize", "dx",        "dy",        "nodata_value"};
    for (word = words.next(); !word.empty(); word = words.next()) {
      const std::string name = lower(std::string(word.substr(0, 40)));
      if (std::ranges::find(known, name) == std::end(known)) return;
      const std::string_view value = words.next();
      const auto number = parse_number(value);
      if (!number)
        throw Unfit(
            fmt::format("'{} {}' is no entry of the header of an ESRI ASCII grid; export the raster again", name, value.substr(0, 40)));
      if (!numbers.try_emplace(name, *number).second)
        throw Unfit(fmt::format("has '{}' twice in its header; export the raster again", name));
    }
  }
  /// Takes dx and dy, which GIS programs write in place of cellsize.
  void take_dx_and_dy() {
    if (has("cellsize") || !has("dx") || !has("dy")) return;
    if (std::abs(get("dx") - get("dy")) > 1e-6 * get("dx"))
      throw Unfit(fmt::format("has cells of {:g} x {:g}; resample it to square ones", get("dx"), get("dy")));
    numbers["cellsize"] = get("dx");
  }
  [[nodiscard]] bool has(std::string_view name) const { return numbers.contains(name); }
  [[nodiscard]] double get(std::string_view name) const { return numbers.find(name)->second; }
};

/// Coordinate of the south-western point along one axis. @param axis  'x' or 'y'
std::optional<double> first_point(const Header& header, char axis, double spacing) {
  const std::string centre = fmt::format("{}llcenter", axis), corner = fmt::format("{}llcorner", axis);
  if (header.has(centre)) return header.get(centre);
  if (header.has(corner)) return header.get(corner) + 0.5 * spacing;
  return std::nullopt;
}

std::string place_text(const HeightField::Points& p, std::size_t column, std::size_t row) {
  return fmt::format("x = {:.6g}, y = {:.6g}", p.first.x() + static_cast<double>(column) * p.spacing,
                     p.first.y() + static_cast<double>(row) * p.spacing);
}

/// @throws Unfit for numbers that are not those of a grid in metres
void check_grid(const HeightField::Points& p) {
  if (!(p.spacing > 0.0))
    throw Unfit(fmt::format("has a cellsize of {:.4g}; give the distance of its points in metres, above 0", p.spacing));
  if (!(p.spacing >= finest_raster && p.spacing <= longest_length))
    throw Unfit(
        fmt::format("has points {:.4g} apart, which are degrees or kilometres, no metres; reproject it to a system in metres", p.spacing));
  const double farthest = std::max(p.first.cwiseAbs().maxCoeff(), p.spacing * static_cast<double>(std::max(p.columns, p.rows)));
  if (!(farthest <= 1e3 * longest_length))
    throw Unfit(fmt::format("has coordinates of {:.4g}; give metres, in the coordinates of the case", farthest));
  for (std::size_t j = 0; j < p.rows; ++j) {
    for (std::size_t i = 0; i < p.columns; ++i) {
      const double h = p.height[j * p.columns + i];
      if (std::isnan(h))
        throw Unfit(fmt::format("has no height at {}; fill the hole (gdal_fillnodata.py), or cut the raster to the part without holes",
                                place_text(p, i, j)));
      if (!(std::abs(h) <= longest_length))
        throw Unfit(fmt::format("has a height of {:.4g} at {}; give metres above the z = 0 of the case", h, place_text(p, i, j)));
    }
  }
}

void check_size(double columns, double rows) {
  if (!(columns >= 2.0 && rows >= 2.0) || columns != std::floor(columns) || rows != std::floor(rows))
    throw Unfit(fmt::format("has {:g} x {:g} points; give at least 2 x 2", columns, rows));
  if (columns * rows > static_cast<double>(most_raster_points)) {
    throw Unfit(fmt::format("has {:g} x {:g} points; at most {} are read: cut it to the surroundings of the obstacle, or resample it",
                            columns, rows, most_raster_points));
  }
}

/// The points of a table x_m, y_m, z_m.
HeightField::Points points_of_table(const Table& table) {
  HeightField::Points points;
  for (const char* column : {"x_m", "y_m", "z_m"}) {
    if (!table.has(column))
      throw Unfit(fmt::format("has no column {}, only '{}'; the first line names x_m, y_m, z_m with commas between", column,
                              fmt::join(table.columns(), ",")));
  }
  const std::vector<double> x = table.numbers("x_m"), y = table.numbers("y_m"), z = table.numbers("z_m");
  for (std::size_t n = 0; n < x.size(); ++n) {
    if (std::isfinite(x[n]) && std::isfinite(y[n])) continue;
    throw Unfit(fmt::format("has no place in row {}; give x_m and y_m", n + 1));
  }
  if (x.size() < 4 || x.size() > most_raster_points) throw Unfit(fmt::format("has {} rows; give 4 to {}", x.size(), most_raster_points));
  points.first = Vec2(*std::ranges::min_element(x), *std::ranges::min_element(y));
  const Vec2 size = Vec2(*std::ranges::max_element(x), *std::ranges::max_element(y)) - points.first;
  points.spacing = size.maxCoeff();
  for (const auto& [along, first] : {std::pair{&x, points.first.x()}, {&y, points.first.y()}}) {
    for (const double coordinate : *along) {
      if (const double way = coordinate - first; way > same_place * finest_raster) points.spacing = std::min(points.spacing, way);
    }
  }
  const auto count = [&](double length) { return static_cast<double>(std::lround(std::min(length / points.spacing, 1e9))) + 1.0; };
  const double columns = count(size.x()), rows = count(size.y());
  const std::string irregular = "is no regular grid with one distance along x and y";
  if (columns * rows != static_cast<double>(x.size()))
    throw Unfit(fmt::format("{}: {} rows, but {:g} x {:g} points {:.6g} m apart span it; resample it", irregular, x.size(), columns, rows,
                            points.spacing));
  check_size(columns, rows);
  points.columns = static_cast<std::size_t>(columns);
  points.rows = static_cast<std::size_t>(rows);
  points.spacing = points.columns >= points.rows ? size.x() / (columns - 1.0) : size.y() / (rows - 1.0);
  points.height.assign(x.size(), 0.0);
  std::vector<char> seen(x.size());
  for (std::size_t n = 0; n < x.size(); ++n) {
    const Vec2 cells = (Vec2(x[n], y[n]) - points.first) / points.spacing;
    const Vec2 nearest = cells.array().round();
    const std::size_t at = static_cast<std::size_t>(nearest.y()) * points.columns + static_cast<std::size_t>(nearest.x());
    if ((cells - nearest).cwiseAbs().maxCoeff() > same_place || at >= x.size() || seen[at] != 0)
      throw Unfit(
          fmt::format("{}: row {}, x_m = {:.6g}, y_m = {:.6g}, is beside it or there twice; resample it", irregular, n + 1, x[n], y[n]));
    seen[at] = 1;
    points.height[at] = z[n];
  }
  check_grid(points);
  return points;
}

/// The points of an ESRI ASCII grid.
HeightField::Points points_of_raster(std::string_view text) {
  HeightField::Points points;
  Words words(without_byte_order_mark(text));
  Header header(words);
  header.take_dx_and_dy();
  for (const char* name : {"ncols", "nrows", "cellsize"}) {
    if (!header.has(name))
      throw Unfit(fmt::format(
          "has no {} in its header; give an ESRI ASCII grid: ncols, nrows, xllcenter, yllcenter, cellsize and the heights", name));
  }
  points.spacing = header.get("cellsize");
  const auto x = first_point(header, 'x', points.spacing), y = first_point(header, 'y', points.spacing);
  if (!x || !y) throw Unfit("has no xllcenter and yllcenter in its header; give them in the coordinates of the case");
  points.first = Vec2(*x, *y);
  check_size(header.get("ncols"), header.get("nrows"));
  points.columns = static_cast<std::size_t>(header.get("ncols"));
  points.rows = static_cast<std::size_t>(header.get("nrows"));
  const std::size_t wanted = points.columns * points.rows;
  points.height.assign(wanted, 0.0);
  const double hole = header.has("nodata_value") ? header.get("nodata_value") : -9999.0;
  std::size_t count = 0;
  for (std::string_view word = header.word; !word.empty(); word = words.next(), ++count) {
    const auto value = parse_number(word);
    if (!value) throw Unfit(fmt::format("has '{}' among its heights; export the raster again", word.substr(0, 40)));
    if (count >= wanted) continue;
    const std::size_t row = points.rows - 1 - count / points.columns;  // from the north
    points.height[row * points.columns + count % points.columns] = *value == hole ? std::numeric_limits<double>::quiet_NaN() : *value;
  }
  if (count != wanted) {
    throw Unfit(fmt::format("has {} heights, {} x {} are needed; the file is cut off or not whole, export it again", count, points.columns,
                            points.rows));
  }
  check_grid(points);
  return points;
}

}  // namespace

HeightField::Points parse_raster(std::string_view text, std::string& problem) try {
  problem.clear();
  return points_of_raster(text);
} catch (const Unfit& raster) {
  problem = raster.what();
  return {};
}

std::string raster_text(const HeightField::Points& p) {
  std::string text = fmt::format("ncols {} nrows {} xllcenter {} yllcenter {} cellsize {}", p.columns, p.rows, format_number(p.first.x()),
                                 format_number(p.first.y()), format_number(p.spacing));
  bool hole_like = false;  // a height of -9999 is one only if the header names another value
  for (const double h : p.height) hole_like |= h == -9999.0;
  if (hole_like) text += " nodata_value nan";
  for (std::size_t j = p.rows; j-- > 0;) {
    for (std::size_t i = 0; i < p.columns; ++i) text.append(" ").append(format_number(p.height[j * p.columns + i]));
  }
  return text;
}

void read_terrain(TerrainSpec& terrain, const std::filesystem::path& folder, ParameterReport& report) {
  if (!report.all_valid({"terrain.file", "terrain.raster"})) return;
  if (!terrain.file && !terrain.raster) return report.problem("terrain", "has no ground; give file or raster");
  if (!terrain.file) {
    try {
      terrain.raster = raster_text(points_of_raster(*terrain.raster));
    } catch (const Unfit& raster) {
      report.problem("terrain.raster", raster.what());
    }
    return;
  }
  const std::string name = *terrain.file, key = "terrain.file";
  const std::filesystem::path path = folder / name;
  const auto refuse = [&](const std::string& text) { report.problem(key, fmt::format("= \"{}\" {}", name, text)); };
  terrain.file.reset();
  std::error_code error;  // a device without end is no raster
  if (!std::filesystem::is_regular_file(path, error))
    return refuse(fmt::format("names no file; it is looked for beside the case, as '{}'", path.string()));
  const std::string ending = lower(path.extension().string());
  if (ending == ".tif" || ending == ".tiff") return refuse("is a GeoTIFF; convert it to an ESRI ASCII grid: gdal_translate -of AAIGrid");
  if (const auto size = std::filesystem::file_size(path, error); error || size > most_raster_bytes)
    return refuse(fmt::format("has more than {} bytes; cut it to the surroundings of the obstacle, or resample it", most_raster_bytes));
  try {
    terrain.raster = raster_text(ending == ".csv" ? points_of_table(Table::read(path)) : points_of_raster(read_text_file(path)));
  } catch (const Unfit& raster) {
    refuse(raster.what());
  } catch (const IoError& unreadable) {
    refuse(fmt::format("cannot be read: {}", unreadable.what()));
  }
}

std::vector<std::string> terrain_problems(const HeightField& ground, const Vec2& low, const Vec2& high, const MirrorPlanes& mirror) {
  std::vector<std::string> problems;
  const double spacing = ground.points().spacing, rounding = 1e-6 * spacing;
  const Vec2 first = ground.points().first, last = ground.last();
  if (((first - low).array() > rounding).any() || ((high - last).array() > rounding).any()) {
    const bool elsewhere = (first.array() > high.array()).any() || (last.array() < low.array()).any();
    problems.push_back(fmt::format(
        "covers x from {:.6g} to {:.6g} m and y from {:.6g} to {:.6g} m, but the domain reaches from {:.6g} to {:.6g} m and from {:.6g} to "
        "{:.6g} m{}; {}",
        first.x(), last.x(), first.y(), last.y(), low.x(), high.x(), low.y(), high.y(), mirror.y ? ", with its image" : "",
        elsewhere ? "give the raster in the coordinates of the case: x downstream from the front of the obstacle, y across, in metres"
                  : "give a larger raster, or a smaller domain"));
    return problems;
  }
  // between the points of the raster, too, where the cubics may be steeper
  const double step = 0.5 * spacing;
  const auto steps = [&](int axis) { return static_cast<int>(std::ceil((high[axis] - low[axis]) / step)); };
  const int columns = steps(0), rows = steps(1);
  double steepest = 0.0, lopsided = 0.0;
  Vec2 steepest_at = low, lopsided_at = low;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const Vec2 at = (low + step * Vec2(i, j)).cwiseMin(high);
      const HeightField::Surface here = ground.at(at);
      if (here.slope.norm() > steepest) steepest = here.slope.norm(), steepest_at = at;
      for (const auto& [mirrored, image] : {std::pair{mirror.x, Vec2(-at.x(), at.y())}, {mirror.y, Vec2(at.x(), -at.y())}}) {
        const double difference = mirrored ? std::abs(ground.at(image).height - here.height) : 0.0;
        if (difference > lopsided) lopsided = difference, lopsided_at = at;
      }
    }
  }
  if (steepest > Terrain::steepest) {
    constexpr double degree = std::numbers::pi / 180.0, cliff = 80.0;
    const double angle = std::atan(steepest) / degree;
    problems.push_back(fmt::format("is {:.1f} degrees steep at x = {:.6g}, y = {:.6g}, more than {:.0f}; {}", angle, steepest_at.x(),
                                   steepest_at.y(), std::atan(Terrain::steepest) / degree,
                                   angle > cliff
                                       ? "check that heights and coordinates have the same unit, metres"
                                       : "smooth the raster there, tilt the case to the mean slope (gravity with it), or leave the "
                                         "step out"));
  }
  constexpr double alike = 1e-3;  // m: less does not matter to a flow
  if (lopsided > alike) {
    problems.push_back(
        fmt::format("is not symmetric: at x = {:.6g}, y = {:.6g} it differs by {:.3g} m from its image beyond the mirror "
                    "plane; leave out the mirror plane (conveyor.mirror_y = false, domain.mirror)",
                    lopsided_at.x(), lopsided_at.y(), lopsided));
  }
  return problems;
}

std::shared_ptr<const HeightField> height_field(const TerrainSpec& terrain) try {
  return std::make_shared<const HeightField>(points_of_raster(terrain.raster.value_or("")));
} catch (const Unfit& raster) {
  throw ConfigError(std::string("[terrain] raster ") + raster.what());
}

}  // namespace mpm
