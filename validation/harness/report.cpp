#include "validation/harness/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
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
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

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
          {"observed_order", c.observed_order ? number(*c.observed_order) : json(nullptr)},
          {"passed", c.passed},
          {"text",
           {{"value", format_value(c.value)},
            {"reference", format_value(c.reference)},
            {"error", format_error(c, c.error)},
            {"tolerance", format_error(c, c.tolerance)},
            {"order", c.observed_order ? fmt::format("{:.2f}", *c.observed_order) : ""}}}};
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

std::string summary_table(const std::vector<CaseResult>& results) {
  std::vector<std::vector<std::string>> rows{
      {"case", "label", "quantity", "reference", "result", "error", "order", "tolerance", "verdict", "time"}};
  for (const CaseResult* r : failing_first(results)) {
    const std::string time = fmt::format("{:.1f} s", r->wall_time_s);
    if (!r->fault.empty()) rows.push_back({r->name, "", r->fault, "", "", "", "", "", "FAILED", time});
    for (const bool failed : {true, false})
      for (const Check& c : r->checks) {
        if (c.passed == failed) continue;
        rows.push_back({r->name, to_string(c.label), c.quantity, format_value(c.reference) + (c.unit.empty() ? "" : " " + c.unit),
                        format_value(c.value), format_error(c, c.error), c.observed_order ? fmt::format("{:.2f}", *c.observed_order) : "",
                        format_error(c, c.tolerance), c.passed ? "ok" : "FAILED", time});
      }
  }
  std::vector<std::size_t> width(rows.front().size(), 0);
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i)
      if (rows.front()[i] != "quantity" || row[1] != "") width[i] = std::max(width[i], row[i].size());  // a long message widens nothing
  std::string text;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::string line;
    for (std::size_t i = 0; i < rows[k].size(); ++i) line += fmt::format("{}{:<{}}", i == 0 ? "" : " | ", rows[k][i], width[i]);
    while (!line.empty() && line.back() == ' ') line.pop_back();
    text += line + '\n';
    if (k == 0) text += std::string(line.size(), '-') + '\n';
  }
  const Count c = count_checks(results);
  std::string failing;
  for (const CaseResult* r : failing_first(results))
    if (!r->passed()) failing += (failing.empty() ? "" : ", ") + r->name;
  if (!failing.empty()) text += fmt::format("failing cases: {}\n", failing);
  return text + fmt::format("{} passed, {} failed\n", c.passed, c.failed);
}

std::string junit_xml(const std::vector<CaseResult>& results, const RunInfo& info) {
  const Count total = count_checks(results);
  std::string xml = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"mpm-validate {}\" tests=\"{}\" failures=\"{}\" time=\"{:.3f}\">\n",
      to_string(info.level), total.passed + total.failed, total.failed, info.wall_time_s);
  for (const CaseResult& r : results) {
    const Count c = count_checks(r);
    xml += fmt::format("  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{:.3f}\">\n", escape(r.name),
                       c.passed + c.failed, c.failed - (r.fault.empty() ? 0 : 1), r.fault.empty() ? 0 : 1, r.wall_time_s);
    for (const Check& k : r.checks) {
      const std::string what = fmt::format("{} reference {}, error {}, tolerance {} ({})", format_value(k.value), format_value(k.reference),
                                           format_error(k, k.error), format_error(k, k.tolerance), k.tolerance_reason);
      xml += fmt::format("    <testcase classname=\"{}\" name=\"{} [{}]\"", escape(r.name), escape(k.quantity), to_string(k.label));
      xml += k.passed ? "/>\n" : fmt::format("><failure message=\"{}\"/></testcase>\n", escape(what));
    }
    if (!r.fault.empty())
      xml +=
          fmt::format("    <testcase classname=\"{}\" name=\"runs\"><error message=\"{}\"/></testcase>\n", escape(r.name), escape(r.fault));
    xml += "  </testsuite>\n";
  }
  return xml + "</testsuites>\n";
}

std::string results_json(const std::vector<CaseResult>& results, const RunInfo& info) {
  const BuildInfo build = build_info();
  const Count total = count_checks(results);
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
            {"passed", total.passed},
            {"failed", total.failed},
            {"cases", json::array()}};
  for (const CaseResult* r : failing_first(results)) {
    json c{{"name", r->name},           {"title", r->title},       {"physics", r->physics},
           {"passed", r->passed()},     {"fault", r->fault},       {"wall_time_s", r->wall_time_s},
           {"notes", r->notes},         {"checks", json::array()}, {"plots", json::array()},
           {"pictures", json::array()}, {"flows", json::array()},  {"studies", json::array()}};
    for (const Check& k : r->checks) c["checks"].push_back(to_json(k));
    for (const Plot& p : r->plots) c["plots"].push_back(to_json(p));
    for (const Picture& p : r->pictures) c["pictures"].push_back({{"file", stored_path(p.file, info)}, {"caption", p.caption}});
    for (const FlowPicture& f : r->flows) c["flows"].push_back(to_json(f, info));
    for (const NamedStudy& s : r->studies) c["studies"].push_back(to_json(s));
    root["cases"].push_back(std::move(c));
  }
  return root.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
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
  write_file(directory / "junit.xml", junit_xml(results, info));
  write_file(directory / "results.json", results_json(results, info));
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
