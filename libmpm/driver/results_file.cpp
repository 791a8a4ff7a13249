#include "libmpm/driver/results_file.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "libmpm/base/error.hpp"
#include "libmpm/io/checksum.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/hdf5.hpp"

namespace mpm {

namespace {

using Json = nlohmann::ordered_json;

std::string with_results(Json json, const Results& results) {
  for (const Result& r : results.entries()) std::visit([&](const auto& value) { json[r.name] = value; }, r.value);
  return with_checksum(json.dump(2) + "\n");  // NaN is not JSON: the serialiser writes null
}

}  // namespace

std::string results_text(const Results& results) { return with_results(Json::object(), results); }

std::string results_text(const Results& results, const std::string& base, const std::filesystem::path& path) {
  Json json = Json::parse(base, nullptr, false);
  if (!json.is_object()) throw IoError(fmt::format("'{}' is not a JSON object; delete it and run `mpm post` again", path.string()));
  return with_results(std::move(json), results);
}

void write_profiles_over_time(const std::filesystem::path& path, std::span<const double> time, const std::vector<HeightProfile>& profiles) {
  hdf5::Writer file(path);
  file.dataset<double>("time_s", time);
  const HeightProfile& heights = profiles.front();
  file.dataset<double>(heights.column.name(), heights.mean);
  for (const HeightProfile& profile : profiles) {
    if (!profile.over_time.empty()) file.dataset<double>(profile.column.name(), profile.over_time, {time.size(), heights.mean.size()});
  }
  file.commit();
}

}  // namespace mpm
