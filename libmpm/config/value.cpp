#include "libmpm/config/value.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "libmpm/config/nearest_word.hpp"
#include "libmpm/config/toml_text.hpp"

namespace mpm::config {

namespace {

/// Whether a word is a number that no key can hold: --set takes text that is not TOML, such as NaN and 1e400, as a word.
std::string number_word_problem(const std::string& word) {
  char* end = nullptr;
  const double x = std::strtod(word.c_str(), &end);
  if (word.empty() || end != word.c_str() + word.size()) return {};
  if (std::isnan(x)) return "is not a finite number";
  if (std::isinf(x)) return word.find_first_of("0123456789") == std::string::npos ? "is not a finite number" : "is too large for a number";
  return {};
}

std::optional<double> number(const toml::node& node, std::string& problem) {
  if (const auto whole = node.value_exact<std::int64_t>()) return static_cast<double>(*whole);
  if (const auto x = node.value_exact<double>()) return x;
  if (const auto word = node.value_exact<std::string>()) problem = number_word_problem(*word);
  return std::nullopt;
}

std::optional<Vec3> vector(const toml::node& node, std::string& problem) {
  const toml::array* list = node.as_array();
  if (list == nullptr) return std::nullopt;
  if (list->size() != 3) {
    problem = fmt::format("has {} entries", list->size());
    return std::nullopt;
  }
  Vec3 v;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto x = number(*list->get(i), problem);
    if (!x && problem.empty()) problem = "holds " + kind_of(*list->get(i));
    if (!x) return std::nullopt;
    v[static_cast<Eigen::Index>(i)] = *x;
  }
  return v;
}

std::optional<Mat3> matrix(const toml::node& node, std::string& problem) {
  const toml::array* rows = node.as_array();
  if (rows == nullptr || rows->size() != 3) return std::nullopt;
  Mat3 result;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = vector(*rows->get(i), problem);
    if (!row) return std::nullopt;
    result.row(static_cast<Eigen::Index>(i)) = row->transpose();
  }
  return result;
}

std::optional<std::vector<std::string>> word_list(const toml::node& node, std::string& problem) {
  const toml::array* list = node.as_array();
  if (list == nullptr) return std::nullopt;
  std::vector<std::string> words;
  for (const toml::node& element : *list) {
    const auto word = element.value_exact<std::string>();
    if (!word) {
      problem = "holds " + shown(element);
      return std::nullopt;
    }
    words.push_back(*word);
  }
  return words;
}

template <class T>
std::optional<Value> as_value(const std::optional<T>& x) {
  return x ? std::optional<Value>(*x) : std::nullopt;
}

/// The value, if it has the type of the key.
std::optional<Value> typed(KeyType type, const toml::node& node, std::string& problem) {
  switch (type) {
    case KeyType::text:
    case KeyType::choice: return as_value(node.value_exact<std::string>());
    case KeyType::number: return as_value(number(node, problem));
    case KeyType::integer: {
      auto whole = as_value(node.value_exact<std::int64_t>());
      if (const auto word = node.value_exact<std::string>()) problem = number_word_problem(*word);
      return whole;
    }
    case KeyType::boolean: return as_value(node.value_exact<bool>());
    case KeyType::vector: return as_value(vector(node, problem));
    case KeyType::matrix: return as_value(matrix(node, problem));
    case KeyType::axes: return as_value(word_list(node, problem));
  }
  return std::nullopt;
}

}  // namespace

std::optional<Value> to_value(const KeyInfo& key, const toml::node& node, std::string& problem) {
  problem.clear();
  std::optional<Value> value = typed(key.type, node, problem);
  if (!value) {
    if (problem.empty()) problem = "is " + kind_of(node);
    return std::nullopt;
  }
  problem = value_problem(key, *value);
  if (problem.empty()) return value;
  if (key.type == KeyType::choice) {
    const std::string meant = nearest_word(std::get<std::string>(*value), key.choices);
    if (!meant.empty()) problem += " (did you mean \"" + meant + "\"?)";
  }
  return std::nullopt;
}

}  // namespace mpm::config
