/// Every key of the schema against hostile values: what is tested follows from the schema alone, so that a key added later is covered.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/estimate.hpp"
#include "support/text.hpp"

namespace mpm {
namespace {

using testing::contains;

/// A file that sets one key, and where its name and its value stand. Whatever else the file lacks is reported as well.
struct OneKey {
  const KeyInfo& key;

  [[nodiscard]] const TableInfo& table() const {
    return *std::ranges::find_if(case_reference().tables, [&](const TableInfo& t) { return t.name == key.table; });
  }
  /// Segments of a path are inline tables; other tables have a header.
  [[nodiscard]] bool inline_table() const { return table().repeated && key.table.find('.') != std::string::npos; }
  [[nodiscard]] std::string header() const {
    if (key.table.empty()) return "";
    if (inline_table()) return "[" + key.table.substr(0, key.table.rfind('.')) + "]\n";
    return (table().repeated ? "[[" + key.table + "]]" : "[" + key.table + "]") + "\n";
  }
  [[nodiscard]] std::string before() const { return inline_table() ? key.table.substr(key.table.rfind('.') + 1) + " = [ { " : ""; }
  [[nodiscard]] int line() const { return key.table.empty() ? 1 : 2; }

  [[nodiscard]] std::string text(const std::string& name, const std::string& value) const {
    return header() + before() + name + " = " + value + (inline_table() ? " } ]" : "") + "\n";
  }
  [[nodiscard]] std::string name_place() const { return fmt::format("file.toml:{}:{}: ", line(), before().size() + 1); }
  [[nodiscard]] std::string value_place() const { return fmt::format("file.toml:{}:{}: ", line(), before().size() + key.name.size() + 4); }
  /// The text before a key in a message.
  [[nodiscard]] std::string label() const {
    return key.table.empty() ? "" : fmt::format("[{}{}] ", key.table, table().repeated ? "[0]" : "");
  }

  /// The message of the reader for a text; empty if it has no fault.
  [[nodiscard]] std::vector<std::string> faults(const std::string& text) const {
    std::vector<std::string> lines;
    try {
      table().in_path && !table().in_case ? (void)parse_path(text, "file.toml") : (void)parse_case(text, "file.toml");
    } catch (const ConfigError& error) {
      std::istringstream in(error.what());
      for (std::string line; std::getline(in, line);) lines.push_back(line);
    }
    return lines;
  }
  /// The line that begins with a place; empty if there is none.
  [[nodiscard]] std::string fault_at(const std::string& place, const std::string& text) const {
    for (const std::string& line : faults(text)) {
      if (line.starts_with(place)) return line;
    }
    return "";
  }
  [[nodiscard]] std::string fault_of_value(const std::string& value) const { return fault_at(value_place(), text(key.name, value)); }
};

bool numeric(const KeyInfo& key) {
  return key.type == KeyType::number || key.type == KeyType::integer || key.type == KeyType::vector || key.type == KeyType::matrix;
}

/// A number as the key takes it: alone, or as one entry of a vector or matrix.
std::string literal(const KeyInfo& key, const std::string& x) {
  const double low = key.range ? key.range->low : 0.0;
  const std::string other = fmt::format("{:.17e}", key.range && key.range->contains(0.0) ? 0.0 : low);
  if (key.type == KeyType::vector) return fmt::format("[{0}, {1}, {0}]", other, x);
  if (key.type == KeyType::matrix) return fmt::format("[[{0}, {0}, {0}], [{0}, {0}, {1}], [{0}, {0}, {0}]]", other, x);
  return x;
}

std::string exact(const KeyInfo& key, double x) {
  return literal(key, key.type == KeyType::integer ? fmt::format("{:.0f}", x) : fmt::format("{:.17e}", x));
}

/// A key that is tried.
struct HostileKey {
  const KeyInfo& key;
  OneKey file{key};

  void expect_refused(const std::string& value, const std::string& why) const {
    const std::string line = file.fault_of_value(value);
    EXPECT_TRUE(line.starts_with(file.value_place() + file.label() + key.name + " = ")) << value << ": " << line;
    EXPECT_TRUE(contains(line, why) && contains(line, "; give ")) << value << ": " << line;
  }
};

/// Tries every key for which `chosen` holds; a failure names its key. One test for all, because a process for each takes a hundred times as
/// long.
template <class Chosen, class Check>
void for_keys(Chosen&& chosen, Check&& check) {
  int tried = 0;
  for (const KeyInfo& key : case_reference().keys) {
    if (!chosen(key)) continue;
    SCOPED_TRACE(key.table + "." + key.name);
    check(HostileKey{key});
    ++tried;
  }
  EXPECT_GT(tried, 0);
}
bool any(const KeyInfo&) { return true; }
bool has_words(const KeyInfo& key) { return key.type == KeyType::choice || key.type == KeyType::axes; }

TEST(HostileKeys, RefuseEveryOtherType) {
  for_keys(any, [](const HostileKey& tried) {
    const KeyInfo& key = tried.key;
    const OneKey& file = tried.file;
    struct Literal {
      std::string text;
      std::vector<KeyType> fits;  ///< types that it may be a value of
    };
    using enum ParameterType;
    const Literal literals[] = {{"true", {boolean}},
                                {"\"zzzzzzzz\"", {text}},
                                {"12345", {number, integer}},
                                {"1.5", {number}},
                                {"[]", {axes}},
                                {"[\"zzzzzzzz\"]", {}},
                                {"[1, 2]", {}},
                                {"[[1, 2, 3]]", {}},
                                {"[[[[]]]]", {}},
                                {"1979-05-27T07:32:00Z", {}},
                                {"07:32:00", {}},
                                {"0x7fffffffffffffff", {number, integer}}};
    for (const Literal& l : literals) {
      if (std::ranges::find(l.fits, key.type) == l.fits.end()) tried.expect_refused(l.text, "");
    }
    // A table in the place of a value is taken for a table, which is unknown.
    const auto lines = file.faults(file.text(key.name, "{ a = 1 }"));
    EXPECT_TRUE(std::ranges::any_of(lines, [&](const std::string& l) { return contains(l, key.name); }));
  });
}

TEST(HostileKeys, HaveARangeAndRefuseWhatLiesBeyondItsEnds) {
  for_keys(numeric, [](const HostileKey& tried) {
    const KeyInfo& key = tried.key;
    const OneKey& file = tried.file;
    if (!key.range) {
      ASSERT_FALSE(key.choices.empty()) << "neither a range nor choices";
      for (const std::string& choice : key.choices) EXPECT_EQ(file.fault_of_value(choice), "");
      for (const char* other : {"0", "-1", "3", "1000000007", "9223372036854775807", "-9223372036854775808"})
        tried.expect_refused(other, "out of range");
      return;
    }
    const Range& range = *key.range;
    ASSERT_TRUE(std::isfinite(range.low) && std::isfinite(range.high));
    ASSERT_FALSE(range.low == 0.0 && range.low_open) << "numbers as small as 5e-324 make counts and quotients overflow: give a least value";
    const bool whole = key.type == KeyType::integer;
    const double step = whole ? 1.0 : 0.0, infinity = std::numeric_limits<double>::infinity();
    const double below = range.low_open ? range.low : whole ? range.low - step : std::nextafter(range.low, -infinity);
    const double above = range.high_open ? range.high : whole ? range.high + step : std::nextafter(range.high, infinity);
    for (const double x : {below, above}) tried.expect_refused(exact(key, x), "out of range");
    const double first = range.low_open ? std::nextafter(range.low, infinity) : range.low;
    const double last = range.high_open ? std::nextafter(range.high, -infinity) : range.high;
    for (const double x : {first, last}) EXPECT_FALSE(contains(file.fault_of_value(exact(key, x)), "out of range")) << x;
    if (whole) {
      for (const char* huge : {"9223372036854775807", "-9223372036854775808"}) tried.expect_refused(huge, "out of range");
      return;
    }
    for (const char* odd : {"nan", "-nan", "inf", "+inf", "-inf"}) tried.expect_refused(literal(key, odd), "finite");
    for (const char* huge : {"1e308", "-1e308", "9223372036854775807", "-9223372036854775808"})
      tried.expect_refused(literal(key, huge), "out of range");
    const auto overflow = file.faults(file.text(key.name, literal(key, "1e999")));  // beyond every double
    EXPECT_TRUE(
        std::ranges::any_of(overflow, [&](const std::string& l) { return l.starts_with(fmt::format("file.toml:{}:", file.line())); }));
  });
}

TEST(HostileKeys, RefuseUnknownWordsAndTakeTheKnownOnes) {
  for_keys(has_words, [](const HostileKey& tried) {
    const KeyInfo& key = tried.key;
    const OneKey& file = tried.file;
    const auto quoted = [&](const std::string& word) { return key.type == KeyType::axes ? "[\"" + word + "\"]" : "\"" + word + "\""; };
    for (const std::string& word : key.choices) {
      EXPECT_FALSE(contains(file.fault_of_value(quoted(word)), "; give ")) << word;
      for (const std::string& wrong : {word + word + word, std::string(10000, 'x')}) tried.expect_refused(quoted(wrong), "");
      if (word.size() < 4) continue;
      const std::string dropped = word.substr(0, word.size() / 2) + word.substr(word.size() / 2 + 1);
      if (key.type == KeyType::choice) tried.expect_refused(quoted(dropped), "(did you mean \"" + word + "\"?)");
    }
  });
}

/// Whether a single insertion, deletion, substitution or swap of neighbours leads from one word to the other.
bool one_edit_apart(std::string_view a, std::string_view b) {
  while (!a.empty() && !b.empty() && a.front() == b.front()) a.remove_prefix(1), b.remove_prefix(1);
  while (!a.empty() && !b.empty() && a.back() == b.back()) a.remove_suffix(1), b.remove_suffix(1);
  return a.size() + b.size() == 1 || (a.size() == 1 && b.size() == 1) || (a.size() == 2 && b.size() == 2 && a[0] == b[1] && a[1] == b[0]);
}

TEST(HostileKeys, MisspeltBringTheRightSuggestion) {
  for_keys(any, [](const HostileKey& tried) {
    const KeyInfo& key = tried.key;
    const OneKey& file = tried.file;
    std::vector<std::string> wrongs;
    for (std::size_t i = 0; i < key.name.size(); ++i) {
      std::string dropped = key.name, changed = key.name, doubled = key.name, swapped = key.name;
      dropped.erase(i, 1);
      changed[i] = key.name[i] == 'q' ? 'k' : 'q';
      doubled.insert(i, 1, key.name[i]);
      if (i > 0) std::swap(swapped[i], swapped[i - 1]);
      wrongs.insert(wrongs.end(), {dropped, changed, doubled, swapped});
    }
    const auto is_key = [](const std::string& name) {
      return std::ranges::any_of(case_reference().keys, [&](const KeyInfo& k) { return k.name == name; });
    };
    for (const std::string& wrong : wrongs) {
      if (is_key(wrong)) continue;
      const std::string line = file.fault_at(file.name_place(), file.text(wrong, "1"));
      const std::string start = file.name_place() + file.label() + "unknown key " + wrong + "; did you mean ";
      ASSERT_TRUE(line.starts_with(start)) << wrong << ": " << line;
      const std::string meant = line.substr(start.size(), line.size() - start.size() - 1);
      EXPECT_TRUE(meant == key.name || one_edit_apart(wrong, meant)) << wrong << ": " << line;
    }
  });
}

TEST(HostileKeys, TwiceAreRefusedWhereTheyStandAgain) {
  for_keys(any, [](const HostileKey& tried) {
    const KeyInfo& key = tried.key;
    const OneKey& file = tried.file;
    const std::string again = file.inline_table() ? file.header() + file.before() + key.name + " = 1, " + key.name + " = 1 } ]\n"
                                                  : file.text(key.name, "1") + key.name + " = 1\n";
    const auto lines = file.faults(again);
    ASSERT_EQ(lines.size(), 1u);
    const int line = file.inline_table() ? file.line() : file.line() + 1;
    EXPECT_TRUE(lines[0].starts_with(fmt::format("file.toml:{}:", line))) << lines[0];
    EXPECT_TRUE(contains(lines[0], key.name)) << lines[0];
  });
}

TEST(HostileKeys, OfAWholeFileAreReportedInOneGo) {
  std::string text;
  std::vector<std::string> expected;
  int line = 0;
  for (const TableInfo& table : case_reference().tables) {
    if (!table.in_case) continue;
    if (!table.name.empty()) text += (table.repeated ? "[[" + table.name + "]]" : "[" + table.name + "]") + "\n", ++line;
    for (const KeyInfo& key : case_reference().keys) {
      if (key.table != table.name) continue;
      text += key.name + " = 07:32:00\n";
      expected.push_back(fmt::format("file.toml:{}:{}: {}{} = ", ++line, key.name.size() + 4, OneKey{key}.label(), key.name));
    }
  }
  const auto lines = OneKey{case_reference().keys.front()}.faults(text);
  std::size_t at = 0;
  for (const std::string& start : expected) {
    while (at < lines.size() && !lines[at].starts_with(start)) ++at;
    ASSERT_LT(at, lines.size()) << start << " is not reported, or not in the order of the file";
  }
}

TEST(HostileTables, MisspeltBringTheRightSuggestionAndTwiceIsRefused) {
  for (const TableInfo& table : case_reference().tables) {
    if (table.name.empty() || table.name.find('.') != std::string::npos) continue;
    const OneKey file{*std::ranges::find_if(case_reference().keys, [&](const KeyInfo& k) { return k.table == table.name; })};
    for (std::size_t i = 0; i < table.name.size(); ++i) {
      const std::string wrong = table.name.substr(0, i) + table.name.substr(i + 1);
      const std::string header = table.repeated ? "[[" + wrong + "]]\n" : "[" + wrong + "]\n";
      const auto lines = file.faults(header);
      const std::string meant = table.repeated ? "[[" + table.name + "]]" : "[" + table.name + "]";
      EXPECT_TRUE(std::ranges::any_of(lines, [&](const std::string& l) {
        return l.starts_with("file.toml:1:") && contains(l, "unknown table [" + wrong + "]; did you mean " + meant + "?");
      })) << wrong;
    }
    if (table.repeated) continue;
    const auto lines = file.faults("[" + table.name + "]\n[" + table.name + "]\n");
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_TRUE(lines[0].starts_with("file.toml:2:") && contains(lines[0], table.name)) << lines[0];
  }
}

class HostileLaw : public ::testing::TestWithParam<ModelInfo> {};

TEST_P(HostileLaw, RefusesTheKeysOfOtherLawsAndAsksForItsOwn) {
  const ModelInfo& model = GetParam();
  const std::string head = "[material]\nmodel = \"" + model.name + "\"\n";
  for (const KeyInfo& key : case_reference().keys) {
    if (key.table != "material" || key.name == "model" || key.name == "density_kg_m3") continue;
    const bool own = std::ranges::find(model.keys, key.name) != model.keys.end();
    const std::string value = key.range                      ? exact(key, 0.5 * (key.range->low + key.range->high))
                              : key.type == KeyType::boolean ? "true"
                                                             : "\"" + key.choices.front() + "\"";
    const auto lines = OneKey{key}.faults(head + key.name + " = " + value + "\n");
    const std::string fault = "[material] " + key.name + " is used with ";
    const auto refusal = std::ranges::find_if(lines, [&](const std::string& l) { return contains(l, fault); });
    EXPECT_EQ(refusal == lines.end(), own) << key.name;
    if (!own && refusal != lines.end()) {
      EXPECT_TRUE(refusal->starts_with("file.toml:3:") && contains(*refusal, "leave it out")) << *refusal;
    }
    const auto without = OneKey{key}.faults(head);
    const bool missed =
        std::ranges::any_of(without, [&](const std::string& l) { return contains(l, "[material] " + key.name + " is missing"); });
    EXPECT_EQ(missed, own && !key.required_when.empty()) << key.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Schema, HostileLaw, ::testing::ValuesIn(case_reference().models), [](const auto& law) { return law.param.name; });

/// Valid cases that hold every table of a case between them: the examples.
std::vector<Case> valid_cases() {
  std::vector<Case> cases;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(MPM_SOURCE_DIR) / "examples")) {
    if (entry.path().extension() == ".toml") cases.push_back(read_case(entry.path()));
  }
  return cases;
}

/// The ends of a range are no sizes that somebody needs, but the reader takes them: then the estimate is made of numbers and the case is
/// refused by it or can be run.
TEST(HostileKeys, AtTheEndsOfTheirRangesMakeAnEstimateOfNumbers) {
  int estimated = 0;
  for (const Case& valid : valid_cases()) {
    const std::string text = write_case(valid);
    for (const KeyInfo& key : case_reference().keys) {
      const OneKey file{key};
      if (!file.table().in_case || !numeric(key) || !key.range) continue;
      for (const double end : {key.range->low, key.range->high}) {
        const std::string path = (key.table.empty() ? "" : key.table + (file.table().repeated ? "[0]." : ".")) + key.name;
        try {
          const Case c = parse_case(text, "case.toml", {path + "=" + exact(key, end)});
          const Estimate e = estimate(c);
          for (const double x : {e.particles, e.time_step, e.steps, e.samples, e.frames, e.memory_bytes, e.disk_bytes, e.wall_time_s})
            EXPECT_TRUE(std::isfinite(x) && x >= 0.0) << path << " = " << end << ": " << x;
          ++estimated;
        } catch (const ConfigError&) {  // the open end of a range, or against another key
        }
      }
    }
  }
  EXPECT_GT(estimated, 50);
}

}  // namespace
}  // namespace mpm
