#include "validation/harness/junit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "libmpm/driver/build_info.hpp"
#include "validation/harness/check_text.hpp"

namespace mpm::validation {
namespace {

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
    }
  }
  return out;
}

/// One case: a test suite with a test case for each check.
std::string test_suite(const CaseResult& r, std::size_t id, const RunInfo& info) {
  const BuildInfo build = build_info();
  const Count c = count_checks(r);
  const std::string timestamp = info.started.substr(0, 19);  // without the zone, as the format has it
  std::string xml;
  const std::size_t tests = c.all(), errors = r.fault.empty() ? 0 : 1;
  const double seconds = r.wall_time_s / static_cast<double>(std::max<std::size_t>(tests, 1));
  xml += fmt::format(
      "  <testsuite name=\"{}\" package=\"mpm-validate\" id=\"{}\" timestamp=\"{}\" hostname=\"localhost\" tests=\"{}\" "
      "failures=\"{}\" errors=\"{}\" time=\"{:.3f}\">\n    <properties>\n",
      escape(r.name), id, escape(timestamp), tests, c.failed - errors, errors, r.wall_time_s);
  for (const auto& [name, value] : {std::pair<const char*, std::string>{"title", r.title},
                                    {"level", to_string(info.level)},
                                    {"version", std::string(build.version)},
                                    {"commit", std::string(build.commit)},
                                    {"machine", info.machine}})
    xml += fmt::format("      <property name=\"{}\" value=\"{}\"/>\n", name, escape(value));
  xml += "    </properties>\n";
  std::map<std::string, int> seen;
  const auto test_case = [&](const std::string& name, const std::string& outcome) {
    const int copy = ++seen[name];
    xml += fmt::format("    <testcase classname=\"{}\" name=\"{}{}\" time=\"{:.3f}\"", escape(r.name), escape(name),
                       copy > 1 ? fmt::format(" ({})", copy) : "", seconds);
    xml += outcome.empty() ? "/>\n" : ">" + outcome + "</testcase>\n";
  };
  if (!r.fault.empty()) test_case("runs", fmt::format("<error type=\"fault\" message=\"{0}\">{0}</error>", escape(r.fault)));
  for (const Check& k : r.checks) {
    std::string what = fmt::format("{} against {}, error {}, tolerance {} ({})", format_value(k.value), format_value(k.reference),
                                   format_error(k, k.error), format_error(k, k.tolerance), k.tolerance_reason);
    if (k.miss) what += fmt::format("; known: {}", format_miss_bound(k));
    test_case(fmt::format("{} [{}]", k.quantity, to_string(k.label)),
              k.verdict() == Verdict::ok ? ""
              : k.verdict() == Verdict::not_met
                  ? fmt::format("<skipped message=\"not met: {}; {}\"/>", escape(k.miss->cause), escape(what))
                  : fmt::format("<failure type=\"{}\" message=\"{}\">{}</failure>", to_string(k.label), escape(what), escape(what)));
  }
  xml += "    <system-out/>\n    <system-err/>\n  </testsuite>\n";
  return xml;
}

}  // namespace

std::string junit_xml(const std::vector<CaseResult>& results, const RunInfo& info) {
  const auto errors =
      static_cast<std::size_t>(std::count_if(results.begin(), results.end(), [](const CaseResult& r) { return !r.fault.empty(); }));
  const Count total = count_checks(results);
  std::string xml = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"mpm-validate {}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" "
      "time=\"{:.3f}\">\n",
      to_string(info.level), total.all(), total.failed - errors, errors, info.wall_time_s);
  for (std::size_t i = 0; i < results.size(); ++i) xml += test_suite(results[i], i, info);
  return xml + "</testsuites>\n";
}

}  // namespace mpm::validation
