#include "validation/harness/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <thread>

#include "mpm/build_info.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/table.hpp"

namespace mpm::validation {
namespace {

using nlohmann::json;

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json numbers(const std::vector<double>& values) {
  json a = json::array();
  for (const double v : values) a.push_back(number(v));
  return a;
}

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

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' ? ' ' : c);
  return out + "\"";
}

/// Six digits: what a reader compares; the last ones may depend on the compiler.
std::string short_number(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : fmt::format("{}", value); }

const char* style_name(Series::Style s) {
  switch (s) {
    case Series::Style::reference: return "reference";
    case Series::Style::simulation: return "simulation";
    case Series::Style::points: return "points";
    case Series::Style::bound: return "bound";
  }
  return "simulation";
}

const char* measure_name(Measure m) {
  switch (m) {
    case Measure::relative: return "relative";
    case Measure::absolute: return "absolute";
    case Measure::at_most: return "at_most";
  }
  return "relative";
}

std::vector<const CaseResult*> failing_first(const std::vector<CaseResult>& results) {
  std::vector<const CaseResult*> order;
  for (const CaseResult& r : results) order.push_back(&r);
  std::stable_partition(order.begin(), order.end(), [](const CaseResult* r) { return !r->passed(); });
  return order;
}

struct Count {
  std::size_t passed = 0, failed = 0;
};
Count count_checks(const CaseResult& r) {
  Count c;
  for (const Check& k : r.checks) ++(k.passed ? c.passed : c.failed);
  if (!r.fault.empty()) ++c.failed;
  return c;
}
Count count_checks(const std::vector<CaseResult>& results) {
  Count total;
  for (const CaseResult& r : results) {
    const Count c = count_checks(r);
    total.passed += c.passed;
    total.failed += c.failed;
  }
  return total;
}

/// verification, validation, regression: those that the case's checks have, in this order.
std::string labels_of(const CaseResult& r) {
  std::string text;
  for (const Label label : {Label::verification, Label::validation, Label::regression})
    if (std::any_of(r.checks.begin(), r.checks.end(), [label](const Check& c) { return c.label == label; }))
      text += (text.empty() ? "" : ", ") + to_string(label);
  return text;
}

/// '35 %', '4.1 %', '< 0.1 %', '250 x', 'inf'
std::string format_used(double used) {
  if (std::isnan(used)) return "";
  if (used > 0.0 && used < 1e-3) return "< 0.1 %";
  if (used < 0.1) return fmt::format("{:.2g} %", 100.0 * used);
  return used < 10.0 ? fmt::format("{:.0f} %", 100.0 * used) : fmt::format("{:.3g} x", used);
}

/// Lines of columns that are as wide as their widest entry of a row that counts; a rule below the first.
std::string aligned(const std::vector<std::vector<std::string>>& rows, const std::vector<bool>& counts) {
  std::vector<std::size_t> width(rows.front().size(), 0);
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t i = 0; i < rows[k].size(); ++i)
      if (counts[k]) width[i] = std::max(width[i], rows[k][i].size());
  std::string text;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::string line;
    for (std::size_t i = 0; i < rows[k].size(); ++i) line += fmt::format("{}{:<{}}", i == 0 ? "" : " | ", rows[k][i], width[i]);
    while (!line.empty() && line.back() == ' ') line.pop_back();
    text += line + '\n';
    if (k == 0) text += std::string(line.size(), '-') + '\n';
  }
  return text;
}

json to_json(const Check& c) {
  return {{"quantity", c.quantity},
          {"label", to_string(c.label)},
          {"value", number(c.value)},
          {"reference", number(c.reference)},
          {"unit", c.unit},
          {"measure", measure_name(c.measure)},
          {"error", number(c.error)},
          {"tolerance", number(c.tolerance)},
          {"tolerance_reason", c.tolerance_reason},
          {"tolerance_used", number(tolerance_used(c))},
          {"observed_order", c.observed_order ? number(*c.observed_order) : json(nullptr)},
          {"passed", c.passed},
          {"text",
           {{"value", format_value(c.value)},
            {"reference", format_value(c.reference)},
            {"error", format_error(c, c.error)},
            {"tolerance", format_error(c, c.tolerance)},
            {"tolerance_used", format_used(tolerance_used(c))},
            {"order", c.observed_order ? fmt::format("{:.2f}", *c.observed_order) : ""}}}};
}

constexpr const char* orders_header = "case,quantity,label,reference,result,error,order,tolerance,verdict,measure,unit";
constexpr const char* runs_header = "level,case,labels,checks_passed,checks_failed,wall_time_s,threads,version,commit,date,machine";

constexpr const char* source_text = R"(# Orders and errors of the validation suite

Written by `mpm-validate run --record`; nothing in this directory is edited by hand.

- `data.csv`: a row a check. `level`, `case`, `quantity`, `label` (verification: exact solution or property; validation: experiment or the paper;
  regression: our own past), `reference`, `result`, `error`, `order` (observed; empty where there is none), `tolerance`, `verdict`, `measure`
  (relative: error and tolerance are shares of the reference; absolute: in `unit`; at_most: `error` is how far the result lies above the
  reference, in `unit`), `unit` of reference and result.
- `runs.csv`: which program and machine made the rows of a case, and how long it took. Times belong to that machine.

Where each reference comes from, and the reason for each tolerance: validation/cases/<case>/README.md.

Last recording: level {level}, `{command}`, version {version}, commit {commit}, {compiler}, {build_type}, {instruction_set}, {machine},
{threads} threads, {started}.
)";

/// Rows of the table of orders and errors by case.
std::map<std::string, std::vector<std::string>> order_rows(const std::vector<CaseResult>& results) {
  std::map<std::string, std::vector<std::string>> rows;
  for (const CaseResult& r : results) {
    if (!r.fault.empty()) rows[r.name].push_back(fmt::format("{},{},,,,,,,FAILED,,", r.name, quoted(r.fault)));
    for (const Check& c : r.checks)
      rows[r.name].push_back(fmt::format("{},{},{},{},{},{},{},{},{},{},{}", r.name, quoted(c.quantity), to_string(c.label),
                                         short_number(c.reference), short_number(c.value), short_number(c.error),
                                         c.observed_order ? short_number(*c.observed_order) : "", short_number(c.tolerance),
                                         c.passed ? "ok" : "FAILED", measure_name(c.measure), quoted(c.unit)));
  }
  return rows;
}

/// Replaces the rows of a CSV file that begin with one of the keys 'level,case'; the rest stays, in the order of the keys.
void merge_csv(const std::filesystem::path& path, const std::string& header, std::map<std::string, std::vector<std::string>> rows) {
  if (std::filesystem::exists(path)) {
    std::istringstream lines(read_file(path));
    std::string line;
    std::getline(lines, line);
    if (line != header)
      throw IoError(fmt::format("cannot add to '{}': its columns are '{}', not '{}'; remove the file", path.string(), line, header));
    std::map<std::string, std::vector<std::string>> kept;
    while (std::getline(lines, line)) {
      const std::string key = line.substr(0, line.find(',', line.find(',') + 1));
      if (!rows.contains(key)) kept[key].push_back(line);
    }
    rows.merge(kept);
  }
  std::string csv = header + "\n";
  for (const auto& [key, list] : rows)
    for (const std::string& row : list) csv += row + "\n";
  write_file(path, csv);
}

json to_json(const Plot& p) {
  json series = json::array();
  for (const Series& s : p.series)
    series.push_back({{"name", s.name}, {"style", style_name(s.style)}, {"x", numbers(s.x)}, {"y", numbers(s.y)}});
  return {{"id", p.id},           {"title", p.title}, {"x_label", p.x_label}, {"y_label", p.y_label},
          {"caption", p.caption}, {"log_x", p.log_x}, {"log_y", p.log_y},     {"series", series}};
}

/// Unit of a field's colour bar; pressures are drawn in kPa.
const char* unit_of(FlowField field) {
  switch (field) {
    case FlowField::speed:
    case FlowField::velocity_x:
    case FlowField::velocity_z: return "m/s";
    case FlowField::pressure:
    case FlowField::stress_xx: return "kPa";
    case FlowField::density: return "kg/m³";
  }
  return "";
}

/// Paths inside the report's directory are written relative to it, so that the directory can be moved and drawn again.
std::string stored_path(const std::filesystem::path& file, const RunInfo& info) {
  const auto inside =
      std::filesystem::absolute(file).lexically_normal().lexically_relative(std::filesystem::absolute(info.directory).lexically_normal());
  return inside.empty() || *inside.begin() == ".." ? std::filesystem::absolute(file).string() : inside.string();
}

json to_json(const FlowPicture& f, const RunInfo& info) {
  return {{"id", f.id},
          {"field", to_string(f.field)},
          {"unit", unit_of(f.field)},
          {"title", f.title},
          {"caption", f.caption},
          {"snapshot", stored_path(f.snapshot, info)},
          {"time_s", number(f.time)},
          {"slice_half_width_m", f.slice_half_width},
          {"window_m", f.window ? json(*f.window) : json(nullptr)},
          {"range", f.range ? json(*f.range) : json(nullptr)},
          {"walls", f.walls},
          {"boxes", f.boxes}};
}

json to_json(const NamedStudy& n) {
  const GridStudy& s = n.study;
  return {{"quantity", n.quantity},
          {"unit", n.unit},
          {"size_label", n.size_label},
          {"size", numbers(s.size)},
          {"value", numbers(s.value)},
          {"behaviour", to_string(s.behaviour)},
          {"order", number(s.order)},
          {"extrapolated", number(s.extrapolated)},
          {"safety_factor", number(s.safety_factor)},
          {"gci", number(s.gci)},
          {"least_squares_order", number(s.least_squares_order)},
          {"least_squares_limit", number(s.least_squares_limit)},
          {"least_squares_uncertainty", number(s.least_squares_uncertainty)},
          {"asymptotic", s.asymptotic},
          {"remark", s.remark}};
}

}  // namespace

std::string format_value(double value) {
  if (value == 0.0) return "0";
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : fmt::format("{}", value);
}

std::string format_error(const Check& check, double error) {
  const auto digits = [](double v) { return v == 0.0 ? std::string("0") : fmt::format("{:.2g}", v); };
  if (check.measure == Measure::relative) {
    if (!std::isfinite(error)) return fmt::format("{}", error);
    return std::abs(error) >= 1e-5 && std::abs(error) < 1e3 ? fmt::format("{:.3g} %", 100.0 * error) : digits(error);
  }
  return check.unit.empty() ? digits(error) : fmt::format("{} {}", digits(error), check.unit);
}

double tolerance_used(const Check& c) {
  if (!std::isfinite(c.value) || !std::isfinite(c.error) || !std::isfinite(c.tolerance)) return std::numeric_limits<double>::infinity();
  const bool bound_without_slack = c.measure == Measure::at_most && c.tolerance == 0.0 && c.reference > 0.0;
  const double used = bound_without_slack ? c.value : c.measure == Measure::at_most ? std::max(c.error, 0.0) : c.error;
  const double permitted = bound_without_slack ? c.reference : c.tolerance;
  if (used <= 0.0) return 0.0;
  return permitted > 0.0 ? used / permitted : std::numeric_limits<double>::infinity();
}

const Check* tightest_check(const CaseResult& result) {
  const auto tightest = std::max_element(result.checks.begin(), result.checks.end(), [](const Check& a, const Check& b) {
    return a.passed != b.passed ? a.passed : tolerance_used(a) < tolerance_used(b);  // one that does not hold before any that does
  });
  return tightest == result.checks.end() ? nullptr : &*tightest;
}

std::optional<double> time_budget(Level level) {
  switch (level) {
    case Level::quick: return 300.0;
    case Level::standard: return 1800.0;
    case Level::full: return std::nullopt;
  }
  return std::nullopt;
}

std::string check_table(const std::vector<CaseResult>& results) {
  std::vector<std::vector<std::string>> rows{
      {"case", "label", "quantity", "reference", "result", "error", "order", "tolerance", "verdict", "time"}};
  std::vector<bool> counts{true};
  for (const CaseResult* r : failing_first(results)) {
    const std::string time = fmt::format("{:.1f} s", r->wall_time_s);
    if (!r->fault.empty()) {
      rows.push_back({r->name, "", r->fault, "", "", "", "", "", "FAILED", time});
      counts.push_back(false);  // a long message widens nothing
    }
    for (const bool failed : {true, false})
      for (const Check& c : r->checks) {
        if (c.passed == failed) continue;
        rows.push_back({r->name, to_string(c.label), c.quantity, format_value(c.reference) + (c.unit.empty() ? "" : " " + c.unit),
                        format_value(c.value), format_error(c, c.error), c.observed_order ? fmt::format("{:.2f}", *c.observed_order) : "",
                        format_error(c, c.tolerance), c.passed ? "ok" : "FAILED", time});
        counts.push_back(true);
      }
  }
  return aligned(rows, counts);
}

std::string case_table(const std::vector<CaseResult>& results, const RunInfo& info) {
  std::vector<std::vector<std::string>> rows{
      {"case", "label", "checks", "closest to its tolerance", "error", "tolerance", "used", "verdict", "time", "share"}};
  double total = 0.0;
  for (const CaseResult& r : results) total += r.wall_time_s;
  std::string failing;
  for (const CaseResult* r : failing_first(results)) {
    const Count c = count_checks(*r);
    const Check* k = tightest_check(*r);
    const bool crashed = !r->fault.empty();
    rows.push_back({r->name, labels_of(*r), fmt::format("{}/{}", c.passed, c.passed + c.failed),
                    crashed        ? "(see its message)"
                    : k != nullptr ? k->quantity
                                   : "",
                    crashed || k == nullptr ? "" : format_error(*k, k->error),
                    crashed || k == nullptr ? "" : format_error(*k, k->tolerance),
                    crashed || k == nullptr ? "" : format_used(tolerance_used(*k)), r->passed() ? "ok" : "FAILED",
                    fmt::format("{:.1f} s", r->wall_time_s), fmt::format("{:.0f} %", total > 0.0 ? 100.0 * r->wall_time_s / total : 0.0)});
    if (!r->passed()) failing += (failing.empty() ? "" : ", ") + r->name;
  }
  std::string text = aligned(rows, std::vector<bool>(rows.size(), true));
  const std::optional<double> budget = time_budget(info.level);
  text += budget ? fmt::format("time: {:.0f} s with {} threads; level {} may take {:.0f} s on two idle cores\n", total, info.threads,
                               to_string(info.level), *budget)
                 : fmt::format("time: {:.0f} s with {} threads\n", total, info.threads);
  if (!failing.empty()) text += fmt::format("failing cases: {}\n", failing);
  const Count c = count_checks(results);
  return text + fmt::format("{} passed, {} failed\n", c.passed, c.failed);
}

std::string junit_xml(const std::vector<CaseResult>& results, const RunInfo& info) {
  const BuildInfo build = build_info();
  const auto errors =
      static_cast<std::size_t>(std::count_if(results.begin(), results.end(), [](const CaseResult& r) { return !r.fault.empty(); }));
  const Count total = count_checks(results);
  const std::string timestamp = info.started.substr(0, 19);  // without the zone, as the format has it
  std::string xml = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"mpm-validate {}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" "
      "time=\"{:.3f}\">\n",
      to_string(info.level), total.passed + total.failed, total.failed - errors, errors, info.wall_time_s);
  std::size_t id = 0;
  for (const CaseResult& r : results) {
    const Count c = count_checks(r);
    const std::size_t tests = c.passed + c.failed, faults = r.fault.empty() ? 0 : 1;
    const double share = r.wall_time_s / static_cast<double>(std::max<std::size_t>(tests, 1));
    xml += fmt::format(
        "  <testsuite name=\"{}\" package=\"mpm-validate\" id=\"{}\" timestamp=\"{}\" hostname=\"localhost\" tests=\"{}\" "
        "failures=\"{}\" errors=\"{}\" time=\"{:.3f}\">\n    <properties>\n",
        escape(r.name), id++, escape(timestamp), tests, c.failed - faults, faults, r.wall_time_s);
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
                         copy > 1 ? fmt::format(" ({})", copy) : "", share);
      xml += outcome.empty() ? "/>\n" : ">" + outcome + "</testcase>\n";
    };
    if (!r.fault.empty()) test_case("runs", fmt::format("<error type=\"fault\" message=\"{0}\">{0}</error>", escape(r.fault)));
    for (const Check& k : r.checks) {
      const std::string what = fmt::format("{} against {}, error {}, tolerance {} ({})", format_value(k.value), format_value(k.reference),
                                           format_error(k, k.error), format_error(k, k.tolerance), k.tolerance_reason);
      test_case(
          fmt::format("{} [{}]", k.quantity, to_string(k.label)),
          k.passed ? "" : fmt::format("<failure type=\"{}\" message=\"{}\">{}</failure>", to_string(k.label), escape(what), escape(what)));
    }
    xml += "    <system-out/>\n    <system-err/>\n  </testsuite>\n";
  }
  return xml + "</testsuites>\n";
}

std::string results_json(const std::vector<CaseResult>& results, const RunInfo& info) {
  const BuildInfo build = build_info();
  const Count total = count_checks(results);
  const std::optional<double> budget = time_budget(info.level);
  json root{{"format_version", 1},
            {"level", to_string(info.level)},
            {"command", info.command},
            {"version", build.version},
            {"commit", build.commit},
            {"compiler", build.compiler},
            {"build_type", build.build_type},
            {"instruction_set", build.instruction_set},
            {"machine", info.machine},
            {"threads", info.threads},
            {"started", info.started},
            {"wall_time_s", info.wall_time_s},
            {"time_budget_s", budget ? json(*budget) : json(nullptr)},
            {"passed", total.passed},
            {"failed", total.failed},
            {"cases", json::array()}};
  for (const CaseResult* r : failing_first(results)) {
    const Count count = count_checks(*r);
    json c{{"name", r->name},
           {"title", r->title},
           {"labels", labels_of(*r)},
           {"physics", r->physics},
           {"passed", r->passed()},
           {"checks_passed", count.passed},
           {"checks_failed", count.failed},
           {"fault", r->fault},
           {"wall_time_s", r->wall_time_s},
           {"command", fmt::format("mpm-validate run --case {} --level {}", r->name, to_string(info.level))},
           {"tightest_check", nullptr},
           {"notes", r->notes}};
    if (const Check* k = tightest_check(*r)) c["tightest_check"] = k - r->checks.data();
    for (const char* list : {"checks", "plots", "pictures", "flows", "studies"}) c[list] = json::array();
    for (const Check& k : r->checks) c["checks"].push_back(to_json(k));
    for (const Plot& p : r->plots) c["plots"].push_back(to_json(p));
    for (const Picture& p : r->pictures) c["pictures"].push_back({{"file", stored_path(p.file, info)}, {"caption", p.caption}});
    for (const FlowPicture& f : r->flows) c["flows"].push_back(to_json(f, info));
    for (const NamedStudy& s : r->studies) c["studies"].push_back(to_json(s));
    root["cases"].push_back(std::move(c));
  }
  return root.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string orders_csv(const std::vector<CaseResult>& results) {
  std::string csv = std::string(orders_header) + "\n";
  for (const auto& [name, rows] : order_rows(results))
    for (const std::string& row : rows) csv += row + "\n";
  return csv;
}

void write_results(const std::filesystem::path& directory, const std::vector<CaseResult>& results, RunInfo info) {
  info.directory = directory;
  make_directory(directory / "data");
  for (const CaseResult& r : results)
    for (const Plot& p : r.plots) {
      std::string csv = fmt::format("# {}: {}\n# x: {}; y: {}\nseries,x,y\n", r.title, p.title, p.x_label, p.y_label);
      for (const Series& s : p.series)
        for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i)
          csv += fmt::format("{},{},{}\n", quoted(s.name), format_number(s.x[i]), format_number(s.y[i]));
      write_file(directory / "data" / fmt::format("{}-{}.csv", r.name, p.id), csv);
    }
  write_file(directory / "orders.csv", orders_csv(results));
  write_file(directory / "junit.xml", junit_xml(results, info));
  write_file(directory / "results.json", results_json(results, info));
}

void record_results(const std::filesystem::path& directory, const std::vector<CaseResult>& results, const RunInfo& info) {
  make_directory(directory);
  const std::string level = to_string(info.level);
  std::map<std::string, std::vector<std::string>> orders, runs;
  for (const auto& [name, rows] : order_rows(results))
    for (const std::string& row : rows) orders[level + ',' + name].push_back(level + ',' + row);
  const BuildInfo build = build_info();
  for (const CaseResult& r : results) {
    const Count c = count_checks(r);
    runs[level + ',' + r.name] = {fmt::format("{},{},{},{},{},{:.1f},{},{},{},{},{}", level, r.name, quoted(labels_of(r)), c.passed,
                                              c.failed, r.wall_time_s, info.threads, build.version, build.commit,
                                              info.started.substr(0, 10), quoted(info.machine))};
    orders.try_emplace(level + ',' + r.name);  // a case without rows replaces those that it had
  }
  merge_csv(directory / "data.csv", fmt::format("level,{}", orders_header), orders);
  merge_csv(directory / "runs.csv", runs_header, runs);
  const std::string command = std::regex_replace(info.command, std::regex(" --(out|junit)[ =][^ ]+"), "");  // folders of one machine
  write_file(directory / "SOURCE.md",
             fmt::format(source_text, fmt::arg("level", level), fmt::arg("command", command), fmt::arg("version", build.version),
                         fmt::arg("commit", build.commit), fmt::arg("compiler", build.compiler), fmt::arg("build_type", build.build_type),
                         fmt::arg("instruction_set", build.instruction_set), fmt::arg("machine", info.machine),
                         fmt::arg("threads", info.threads), fmt::arg("started", info.started)));
}

std::vector<RecordedCase> recorded_cases(const std::filesystem::path& directory) {
  std::vector<RecordedCase> all;
  if (!std::filesystem::exists(directory / "runs.csv")) return all;
  const Table table = Table::read(directory / "runs.csv");
  const auto level = table.text("level"), name = table.text("case"), labels = table.text("labels");
  const auto time = table.numbers("wall_time_s");
  for (std::size_t i = 0; i < table.rows(); ++i) all.push_back({level[i], name[i], labels[i], time[i]});
  return all;
}

std::string describe_machine() {
  std::string model = "unknown processor", line;
  std::ifstream cpu("/proc/cpuinfo");
  while (std::getline(cpu, line))
    if (line.rfind("model name", 0) == 0) {
      model = line.substr(line.find(':') + 2);
      break;
    }
  return fmt::format("{}, {} hardware threads", model, std::thread::hardware_concurrency());
}

}  // namespace mpm::validation
