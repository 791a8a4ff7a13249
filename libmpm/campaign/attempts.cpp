#include "libmpm/campaign/attempts.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/json_object.hpp"

namespace mpm {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int attempts_format_version = 1;

}  // namespace

std::vector<Attempt> read_attempts(const fs::path& directory, const CampaignRun& run) {
  const fs::path file = directory / "attempts.json";
  if (!fs::exists(file)) return {};
  const Json json = read_json_object(file);
  try {
    if (json.value("case_hash", "") != run.case_hash || json.value("end_s", -1.0) != Sampling(run.spec).end()) return {};
    std::vector<Attempt> attempts;
    for (const Json& a : json.at("attempts")) {
      const auto whole = [&](const char* key) {
        return a.contains(key) && a[key].is_number_integer() ? std::optional(a[key].get<int>()) : std::nullopt;
      };
      attempts.push_back({a.value("started", ""), a.value("ended", ""), a.value("host", ""), a.value("outcome", ""), whole("exit_code"),
                          whole("signal"), a.value("cause", ""), a.value("final", false)});
    }
    return attempts;
  } catch (const Json::exception&) {  // a value of another type
    throw IoError(fmt::format("'{}' is damaged: it is no list of attempts; delete it", file.string()));
  }
}

void write_attempts(const fs::path& directory, const CampaignRun& run, const std::vector<Attempt>& attempts) {
  Json json{{"format_version", attempts_format_version}, {"case_hash", run.case_hash}, {"end_s", Sampling(run.spec).end()}};
  json["attempts"] = Json::array();
  for (const Attempt& a : attempts) {
    const auto whole = [](const std::optional<int>& x) { return x ? Json(*x) : Json(); };
    json["attempts"].push_back({{"started", a.started},
                                {"ended", a.ended},
                                {"host", a.host},
                                {"outcome", a.outcome},
                                {"exit_code", whole(a.exit_code)},
                                {"signal", whole(a.signal)},
                                {"cause", a.cause},
                                {"final", a.final}});
  }
  write_file(directory / "attempts.json", json_text(json, 2));
}

}  // namespace mpm
