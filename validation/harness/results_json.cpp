#include "validation/harness/results_json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "libmpm/driver/build_info.hpp"
#include "validation/harness/check_text.hpp"
#include "validation/harness/summary.hpp"

namespace mpm::validation {
namespace {

using nlohmann::json;

const char* style_name(Series::Style s) {
  switch (s) {
    case Series::Style::reference: return "reference";
    case Series::Style::simulation: return "simulation";
    case Series::Style::points: return "points";
    case Series::Style::bound: return "bound";
  }
  return "simulation";
}

json to_json(const Check& c) {
  return {{"quantity", c.quantity},
          {"label", to_string(c.label)},
          {"value", c.value},
          {"reference", c.reference},
          {"unit", c.unit},
          {"measure", measure_name(c.measure)},
          {"error", c.error},
          {"tolerance", c.tolerance},
          {"tolerance_reason", c.tolerance_reason},
          {"tolerance_used", tolerance_used(c)},
          {"observed_order", c.observed_order ? json(*c.observed_order) : json(nullptr)},
          {"passed", c.passed},
          {"verdict", to_string(c.verdict())},
          {"miss_cause", c.miss ? c.miss->cause : ""},
          {"miss_bound", c.miss ? json(c.miss->bound) : json(nullptr)},
          {"text",
           {{"value", format_value(c.value)},
            {"reference", format_value(c.reference)},
            {"error", format_error(c, c.error)},
            {"tolerance", format_error(c, c.tolerance)},
            {"tolerance_used", format_used(tolerance_used(c))},
            {"miss_bound", format_miss_bound(c)},
            {"order", format_order(c.observed_order)}}}};
}

json to_json(const Plot& p) {
  json series = json::array();
  for (const Series& s : p.series) series.push_back({{"name", s.name}, {"style", style_name(s.style)}, {"x", s.x}, {"y", s.y}});
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
          {"time_s", f.time},
          {"slice_half_width_m", f.slice_half_width},
          {"window_m", f.window ? json(*f.window) : json(nullptr)},
          {"range", f.range ? json(*f.range) : json(nullptr)},
          {"walls", f.walls},
          {"boxes", f.boxes}};
}

json to_json(const NamedConvergence& n) {
  const Convergence& s = n.convergence;
  return {{"quantity", n.quantity},
          {"unit", n.unit},
          {"size_label", n.size_label},
          {"size", s.size},
          {"value", s.value},
          {"behaviour", to_string(s.behaviour)},
          {"order", s.order},
          {"extrapolated", s.extrapolated},
          {"safety_factor", s.safety_factor},
          {"gci", s.gci},
          {"uncertainty", s.uncertainty},
          {"least_squares_order", s.least_squares_order},
          {"least_squares_limit", s.least_squares_limit},
          {"least_squares_uncertainty", s.least_squares_uncertainty},
          {"asymptotic", s.asymptotic},
          {"remark", s.remark}};
}

json to_json(const CaseResult& r, const RunInfo& info) {
  const Count count = count_checks(r);
  json c{
      {"name", r.name},
      {"title", r.title},
      {"labels", labels_of(r)},
      {"physics", r.physics},
      {"passed", r.passed()},
      {"verdict", format_verdict(r)},
      {"checks_passed", count.passed},
      {"checks_failed", count.failed},
      {"checks_not_met", count.not_met},
      {"fault", r.fault},
      {"wall_time_s", r.wall_time_s},
      {"command", info.solver.empty() ? fmt::format("mpm-validate run --case {} --level {}", r.name, to_string(info.level)) : info.command},
      {"tightest_check", nullptr},
      {"notes", r.notes}};
  for (std::size_t i = 0; i < r.checks.size(); ++i) {
    if (&r.checks[i] == tightest_check(r)) c["tightest_check"] = i;
  }
  for (const char* list : {"checks", "plots", "pictures", "flows", "studies"}) c[list] = json::array();
  for (const Check& k : r.checks) c["checks"].push_back(to_json(k));
  for (const Plot& p : r.plots) c["plots"].push_back(to_json(p));
  for (const Picture& p : r.pictures) c["pictures"].push_back({{"file", stored_path(p.file, info)}, {"caption", p.caption}});
  for (const FlowPicture& f : r.flows) c["flows"].push_back(to_json(f, info));
  for (const NamedConvergence& s : r.convergences) c["studies"].push_back(to_json(s));
  return c;
}

json to_json(const SummaryPoint& p) {
  const Comparison& c = p.comparison;
  return {{"quantity", text_of(c.quantity).name},
          {"case", p.case_name},
          {"name", p.name},
          {"label", to_string(p.label)},
          {"predicted", c.predicted},
          {"reference", c.reference},
          {"unit", text_of(c.quantity).unit},
          {"ratio", c.ratio()},
          {"reference_uncertainty", c.reference_uncertainty},
          {"text", fmt::format("{} against {} {}", format_value(c.predicted), format_value(c.reference), text_of(c.quantity).unit)}};
}

json to_json(const SummaryRow& r) {
  return {{"quantity", text_of(r.quantity).name},
          {"unit", text_of(r.quantity).unit},
          {"label", to_string(r.label)},
          {"values", r.values},
          {"cases", r.cases},
          {"without_ratio", r.without_ratio},
          {"reference_uncertainty", r.reference_uncertainty},
          {"bias", r.bias},
          {"spread", r.spread},
          {"model_spread", r.model_spread},
          {"farthest", r.farthest},
          {"farthest_name", r.farthest_name}};
}

json summary_json(const std::vector<CaseResult>& results) {
  json summary{{"rows", json::array()}, {"points", json::array()}};
  const std::vector<SummaryPoint> points = summary_points(results);
  for (const SummaryRow& row : summary_rows(points)) summary["rows"].push_back(to_json(row));
  for (const SummaryPoint& point : points) summary["points"].push_back(to_json(point));
  return summary;
}

}  // namespace

std::string results_json(const std::vector<CaseResult>& results, const RunInfo& info) {
  const BuildInfo build = build_info();
  const Count total = count_checks(results);
  const std::optional<double> budget = time_budget(info.level);
  json root{{"format_version", 1},
            {"level", to_string(info.level)},
            {"precision", name_of(info.precision)},
            {"command", info.command},
            {"solver", info.solver},
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
            {"not_met", total.not_met},
            {"summary", summary_json(results)},
            {"cases", json::array()}};
  for (const CaseResult* r : failing_first(results)) root["cases"].push_back(to_json(*r, info));
  return root.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace mpm::validation
