/// Every key of a case: wrong types, values out of range, misspellings. Cases and values follow from the schema alone, so that a key added
/// later is covered.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "libmpm/driver/case_file.hpp"
#include "support/case_texts.hpp"

namespace mpm {
namespace {

using testing::arm_case;
using testing::ground_case;
using testing::hand_case;
using testing::law_cases;
using testing::lines_of;
using testing::message_of;
using testing::reports;
using testing::sheared_case;
using testing::strip_case;
using testing::surge_case;
using testing::window_case;

/// A case that sets a key, and the line of the key (counted from 1).
struct Setting {
  std::string text;
  const config::Key* key;
  int line;
};

/// The lines of an entry of a table: behind its heading to the next one. @returns first and last, counted from 1; {0, -1} without such a
/// table
std::pair<int, int> lines_of_table(const std::vector<std::string>& lines, const std::string& table) {
  const auto is = [](const std::string& line, const std::string& name) { return line == "[" + name + "]" || line == "[[" + name + "]]"; };
  std::size_t begin = 0;
  while (!table.empty() && begin < lines.size() && !is(lines[begin], table)) ++begin;
  if (begin == lines.size()) return {0, -1};
  std::size_t end = table.empty() ? 0 : begin + 1;
  const auto first = static_cast<int>(end) + 1;
  while (end < lines.size() && !lines[end].starts_with("[")) ++end;
  return {first, static_cast<int>(end)};
}

/// The line of a key in the first entry of its table; 0 where it is not set.
int line_of(const std::string& text, const KeyInfo& key) {
  const auto lines = lines_of(text);
  const auto [first, last] = lines_of_table(lines, key.table);
  for (int n = first; n <= last; ++n) {
    if (lines[static_cast<std::size_t>(n) - 1].starts_with(key.name + " = ")) return n;
  }
  return 0;
}

/// Cases in which keys are tried: with and without a conveyor, of every law.
const std::vector<Case>& bases() {
  static const std::vector<Case> all = [] {
    std::vector<Case> cases;
    for (const std::string* text : {&window_case, &arm_case, &surge_case, &sheared_case, &hand_case, &ground_case})
      cases.push_back(parse_case(*text, "base.toml"));
    for (const std::string& text : law_cases()) cases.push_back(parse_case(text, "law.toml"));
    return cases;
  }();
  return all;
}

/// Sets other keys so that a condition holds. @returns whether that is possible in this case
bool fulfil(Case& c, const config::Table& table, const Condition& condition) {
  for (const Condition::Test& test : condition.tests) {
    if (case_schema().holds({{test}}, table, &c, 0)) continue;
    if (test.key.empty()) return false;  // another kind of scene
    const config::Key& other = *case_schema().find_key(table.name, test.key);
    if (!fulfil(c, table, other.used)) return false;
    other.set(&c, 0, test.below ? config::Value(0.5 * *test.below) : config::Value(test.words.front()));
  }
  return true;
}

/// Values that may be right for a key, the likeliest first.
std::vector<config::Value> candidates(const config::Key& key, const Case& c) {
  std::vector<config::Value> values;
  if (const auto now = key.get(&c, 0)) values.push_back(*now);
  if (key.preset) values.push_back(*key.preset);
  std::vector<double> numbers{0.5, 1.0, 1.625, 2.0, 20.0};
  if (key.range) {
    for (const double x : {key.range->low, key.range->high, 0.5 * (key.range->low + key.range->high)}) numbers.push_back(x);
  }
  switch (key.type) {
    case KeyType::number:
      for (const double x : numbers) values.emplace_back(x);
      break;
    case KeyType::vector:
      for (const double x : numbers) values.emplace_back(Vec3(x, x, x));
      break;
    case KeyType::integer:
      for (const double x : numbers) values.emplace_back(static_cast<std::int64_t>(x));
      break;
    case KeyType::boolean:
      for (const bool flag : {true, false}) values.emplace_back(flag);
      break;
    case KeyType::choice:
      for (const std::string& word : key.choices) values.emplace_back(word);
      break;
    case KeyType::axes:
      for (const std::string& axis : key.choices) values.emplace_back(std::vector<std::string>{axis});
      break;
    case KeyType::text: values.emplace_back(std::string("a text")); break;
    case KeyType::matrix: break;  // of point paths only
  }
  return values;
}

/// A text without the keys that set the same quantity as this one.
std::string without_rivals(const std::string& text, const config::Key& key) {
  std::string out;
  const auto rivals = case_schema().rivals(config::key_path(key.table, key.name));
  const auto lines = lines_of(text);
  const auto [first, last] = lines_of_table(lines, key.table);
  for (int n = 1; n <= static_cast<int>(lines.size()); ++n) {
    const std::string& line = lines[static_cast<std::size_t>(n) - 1];
    const std::string path = config::key_path(key.table, line.substr(0, line.find(' ')));
    if (n < first || n > last || std::ranges::find(rivals, path) == rivals.end()) out += line + "\n";
  }
  return out;
}

/// A valid case that sets the key, found from the schema alone; none if no candidate is accepted in any of the bases.
std::optional<Setting> setting_of(const config::Table& table, const config::Key& key) {
  for (const Case& base : bases()) {
    Case fitting = base;
    if (table.entries(&fitting) == 0 || !fulfil(fitting, table, key.used)) continue;
    for (const config::Value& value : candidates(key, fitting)) {
      Case c = fitting;
      key.set(&c, 0, value);
      const std::string text = without_rivals(write_case(c), key);
      if (const int line = line_of(text, key); line > 0 && message_of(text).empty()) return Setting{text, &key, line};
    }
  }
  return std::nullopt;
}

/// One setting for every key that may be in a case, as far as there is one.
const std::vector<Setting>& every_case_key() {
  static const std::vector<Setting> all = [] {
    std::vector<Setting> settings;
    for (const config::Table& table : case_schema().tables()) {
      for (const config::Key& key : table.keys) {
        if (auto setting = setting_of(table, key)) settings.push_back(std::move(*setting));
      }
    }
    return settings;
  }();
  return all;
}

std::string with_line(const Setting& setting, const std::string& line) {
  std::string out;
  int number = 0;
  for (const std::string& old : lines_of(setting.text)) out += (++number == setting.line ? line : old) + "\n";
  return out;
}

std::string value_place(const Setting& setting) { return fmt::format("case.toml:{}:{}: ", setting.line, setting.key->name.size() + 4); }
std::string key_place(const Setting& setting) { return fmt::format("case.toml:{}:1: ", setting.line); }

/// Tries every key that has a setting; a failure names its key.
template <class Check>
void for_keys(Check&& check) {
  ASSERT_FALSE(every_case_key().empty());
  for (const Setting& setting : every_case_key()) {
    SCOPED_TRACE(config::key_path(setting.key->table, setting.key->name));
    check(setting);
  }
}

TEST(EveryKey, OfWrongTypeIsReportedWithPlaceAndRemedy) {
  for_keys([](const Setting& s) {
    const std::string wrong = s.key->type == KeyType::boolean ? "1" : "true";
    const std::string message = message_of(with_line(s, s.key->name + " = " + wrong));
    EXPECT_TRUE(reports(message, value_place(s), {s.key->name + " = " + wrong, "give "}));
    EXPECT_TRUE(reports(message_of(with_line(s, s.key->name + " = 2020-02-02")), value_place(s), {"date"}));
  });
}

TEST(EveryKey, OutOfRangeIsReportedWithPlaceValueAndRange) {
  for_keys([](const Setting& s) {
    const auto refused = [&](const std::string& value, const std::vector<std::string>& words) {
      const std::string message = message_of(with_line(s, s.key->name + " = " + value));
      EXPECT_TRUE(reports(message, value_place(s), words)) << value;
    };
    switch (s.key->type) {
      case KeyType::number:
      case KeyType::vector:
      case KeyType::matrix: {
        ASSERT_TRUE(s.key->range);
        const auto literal = [&](const std::string& x) { return s.key->type == KeyType::vector ? "[0.5, " + x + ", 0]" : x; };
        const Range& range = *s.key->range;
        const double low = range.low_open ? range.low : range.low - 1e-3 * std::max(1.0, std::abs(range.low));
        const double high = range.high_open ? range.high : range.high + 1e-3 * std::max(1.0, std::abs(range.high));
        refused(literal(fmt::format("{:.17e}", low)), {"out of range", fmt::format("{:g}", range.low)});
        refused(literal(fmt::format("{:.17e}", high)), {"out of range", fmt::format("{:g}", range.high)});
        for (const char* odd : {"nan", "inf", "-inf", "+nan"}) refused(literal(odd), {"finite"});
        break;
      }
      case KeyType::integer:
        if (s.key->range) {
          refused(fmt::format("{}", s.key->range->low - 1), {"out of range", fmt::format("{:g}", s.key->range->low)});
        } else {
          refused("9", {"out of range", s.key->choices.front()});
        }
        break;
      case KeyType::choice: refused("\"zzzzzzzz\"", {"not known", s.key->choices.front()}); break;
      case KeyType::axes:
        refused("[\"z\"]", {"holds \"z\""});
        refused("[\"x\", \"x\"]", {"twice"});
        refused("[1]", {"holds 1"});
        break;
      case KeyType::text:
      case KeyType::boolean: break;  // no range
    }
  });
}

TEST(EveryKey, MisspeltIsReportedWithTheRightSuggestion) {
  for_keys([](const Setting& s) {
    const std::string line = lines_of(s.text)[static_cast<std::size_t>(s.line) - 1];
    const std::string& name = s.key->name;
    std::string doubled = name, dropped = name, swapped = name;
    doubled.insert(2, 1, name[2]);
    dropped.erase(name.size() / 2, 1);
    std::swap(swapped[1], swapped[2]);
    for (const std::string& wrong : {doubled, dropped, swapped}) {
      if (wrong == name) continue;
      const std::string message = message_of(with_line(s, wrong + line.substr(name.size())));
      EXPECT_TRUE(reports(message, key_place(s), {"unknown key " + wrong + "; did you mean " + name + "?"}));
      EXPECT_EQ(lines_of(message).size(), 1u) << message;  // and not as missing, too
    }
  });
}

TEST(EveryKey, InAnotherTableIsSentToItsOwn) {
  for_keys([](const Setting& s) {
    const std::string foreign = s.key->table == "output" ? "numerics" : "output";
    const std::string message = message_of(strip_case + (foreign == "output" ? "" : "[numerics]\n") + s.key->name + " = 1\n");
    EXPECT_TRUE(reports(message, "case.toml:", {"unknown key " + s.key->name + "; it belongs in "}));
  });
}

TEST(EveryKey, SurvivesReadingAndWriting) {
  for_keys([](const Setting& s) {
    const Case c = parse_case(s.text, "case.toml");
    const std::string written = write_case(c);
    EXPECT_EQ(parse_case(written, "written.toml"), c);
    EXPECT_EQ(write_case(parse_case(written, "written.toml")), written);
  });
}

TEST(EveryKeyOfTheSchema, IsTriedInACase) {
  const auto& tried = every_case_key();
  for (const config::Table& table : case_schema().tables()) {
    for (const config::Key& key : table.keys) {
      // these need a file beside the case: tests/driver/test_inflow_csv.cpp, test_terrain_raster.cpp
      if (key.name == "inflow_csv" || (table.name == "terrain" && key.name == "file")) continue;
      EXPECT_TRUE(std::ranges::any_of(tried, [&](const Setting& s) { return s.key == &key; }))
          << table.name << "." << key.name << ": none of the candidates makes a valid case; add a base that has it";
    }
  }
}

}  // namespace
}  // namespace mpm
