#include "validation/harness/time_record.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "libmpm/io/csv.hpp"

namespace mpm::validation {

double TimeRecord::at(double t) const {
  const auto after = static_cast<std::size_t>(std::ranges::upper_bound(time, t) - time.begin());
  if (after == 0) return value.front();
  if (after == time.size()) return value.back();
  const double share = (t - time[after - 1]) / (time[after] - time[after - 1]);
  return value[after - 1] + share * (value[after] - value[after - 1]);
}

double TimeRecord::mean(double from, double to) const {
  double sum = 0.0, t = from, y = at(from);
  const auto go_to = [&](double next, double there) {
    sum += 0.5 * (next - t) * (y + there);
    t = next;
    y = there;
  };
  for (std::size_t i = 0; i < time.size(); ++i)
    if (time[i] > from && time[i] <= to) go_to(time[i], value[i]);
  go_to(to, at(to));
  return sum / (to - from);
}

double TimeRecord::first_above(double level) const {
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (value[i] < level) continue;
    return i == 0 ? time[0] : time[i - 1] + (time[i] - time[i - 1]) * (level - value[i - 1]) / (value[i] - value[i - 1]);
  }
  return std::numeric_limits<double>::infinity();
}

TimeRecord read_record(const std::filesystem::path& table, const std::string& quantity) {
  const Table rows = Table::read(table);
  const std::vector<std::string> names = rows.text("quantity");
  const std::vector<double> times = rows.numbers("time_s"), values = rows.numbers("value");
  std::vector<std::pair<double, double>> points;
  for (std::size_t i = 0; i < rows.rows(); ++i)
    if (names[i] == quantity) points.emplace_back(times[i], values[i]);
  if (points.empty()) throw IoError(table.string() + ": no rows of the quantity '" + quantity + "'");
  std::ranges::stable_sort(points, {}, &std::pair<double, double>::first);
  TimeRecord record;
  for (const auto& [t, y] : points) record.time.push_back(t), record.value.push_back(y);
  return record;
}

}  // namespace mpm::validation
