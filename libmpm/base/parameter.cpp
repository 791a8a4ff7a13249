#include "libmpm/base/parameter.hpp"

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"

namespace mpm {

namespace {

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) text.append(text.empty() ? "" : between).append(word);
  return text;
}

std::string number_problem(const ParameterInfo& parameter, double x) {
  if (!std::isfinite(x)) return "is not a finite number";
  return parameter.range && !parameter.range->contains(x) ? "is out of range" : "";
}

}  // namespace

std::string Condition::text() const {
  if (always()) return "always";
  std::string text;
  for (const Test& test : tests) {
    text += text.empty() ? "" : " and ";
    if (test.key.empty()) {
      text += (test.present ? "[" : "no [") + test.table + "]";
    } else if (test.below) {
      text += test.key + " below " + number_text(*test.below);
    } else {
      text += test.key + " = \"" + joined(test.words, "\" or \"") + "\"";
    }
  }
  return text;
}

std::string range_text(const Range& range) {
  return std::string(range.low_open ? "(" : "[") + number_text(range.low) + ", " + number_text(range.high) + (range.high_open ? ")" : "]");
}

std::string expected_value(const ParameterInfo& p) {
  const std::string range = p.range ? " in " + range_text(*p.range) : "", unit = p.unit.empty() ? "" : " " + p.unit;
  switch (p.type) {
    case ParameterType::text: return "a string in quotes";
    case ParameterType::choice: return "one of \"" + joined(p.choices, "\", \"") + "\"";
    case ParameterType::number: return "a number" + range + unit;
    case ParameterType::integer: return p.choices.empty() ? "an integer" + range : "one of " + joined(p.choices, ", ");
    case ParameterType::boolean: return "true or false";
    case ParameterType::vector: return "three numbers [x, y, z], each" + range + unit;
    case ParameterType::matrix: return "three rows of three numbers, each" + range + unit;
    case ParameterType::axes: return "a list of distinct axes out of \"" + joined(p.choices, "\", \"") + "\"";
  }
  return {};
}

std::string value_text(const ParameterValue& value) {
  constexpr int digits = 9;
  if (const auto* x = std::get_if<double>(&value)) return number_text(*x, digits);
  if (const auto* x = std::get_if<Vec3>(&value)) return vector_text(*x, digits);
  if (const auto* x = std::get_if<Mat3>(&value)) {
    return std::string("(") + vector_text(Vec3(x->row(0)), digits) + ", " + vector_text(Vec3(x->row(1)), digits) + ", " +
           vector_text(Vec3(x->row(2)), digits) + ")";
  }
  if (const auto* n = std::get_if<std::int64_t>(&value)) return std::to_string(*n);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* word = std::get_if<std::string>(&value)) return "\"" + *word + "\"";
  return std::string("[") + joined(std::get<std::vector<std::string>>(value), ", ") + "]";
}

std::string value_problem(const ParameterInfo& p, const ParameterValue& value) {
  const auto known = [&](const std::string& word) { return std::find(p.choices.begin(), p.choices.end(), word) != p.choices.end(); };
  const auto first_problem = [&](const auto& numbers) {
    for (const double x : numbers.reshaped()) {
      if (std::string problem = number_problem(p, x); !problem.empty()) return problem;
    }
    return std::string();
  };
  if (const auto* x = std::get_if<double>(&value)) return number_problem(p, *x);
  if (const auto* x = std::get_if<Vec3>(&value)) return first_problem(*x);
  if (const auto* x = std::get_if<Mat3>(&value)) return first_problem(*x);
  if (const auto* n = std::get_if<std::int64_t>(&value)) {
    if (!p.choices.empty() && !known(std::to_string(*n))) return "is out of range";
    return number_problem(p, static_cast<double>(*n));
  }
  if (const auto* word = std::get_if<std::string>(&value)) return p.choices.empty() || known(*word) ? "" : "is not known";
  if (const auto* words = std::get_if<std::vector<std::string>>(&value)) {
    for (auto word = words->begin(); word != words->end(); ++word) {
      if (!known(*word)) return "holds \"" + *word + "\"";
      if (std::find(words->begin(), word, *word) != word) return "names an axis twice";
    }
  }
  return {};
}

namespace detail {

void CollectedProblems::problem(const std::string& name, const std::string& text) {
  names_.push_back(name);
  message_ += (message_.empty() ? "" : "\n") + name + " " + text;
}

void CollectedProblems::throw_if_any() const {
  if (!message_.empty()) throw ConfigError(message_);
}

}  // namespace detail

}  // namespace mpm
