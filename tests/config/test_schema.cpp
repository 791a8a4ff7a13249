#include "libmpm/driver/case_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "libmpm/base/text.hpp"
#include "libmpm/material/any_material.hpp"

namespace mpm {
namespace {

TEST(Schema, DeclaresEveryKeyOnceInAKnownTable) {
  std::set<std::string> tables;
  for (const TableInfo& table : case_reference().tables) EXPECT_TRUE(tables.insert(table.name).second) << table.name;
  std::set<std::pair<std::string, std::string>> seen;
  for (const KeyInfo& key : case_reference().keys) {
    EXPECT_TRUE(seen.insert({key.table, key.name}).second) << key.table << "." << key.name;
    EXPECT_TRUE(tables.contains(key.table)) << key.table;
  }
}

TEST(Schema, EveryKeyIsDescribedAndHasARangeOrChoicesWhereItsTypeAllowsThem) {
  for (const KeyInfo& key : case_reference().keys) {
    SCOPED_TRACE(key.table + "." + key.name);
    EXPECT_FALSE(key.description.empty());
    EXPECT_TRUE(!key.default_text.empty() || !key.required_when.empty());
    const bool numeric = key.type == KeyType::number || key.type == KeyType::vector || key.type == KeyType::matrix;
    EXPECT_EQ(key.range.has_value(), numeric || (key.type == KeyType::integer && key.choices.empty()));
    EXPECT_TRUE(!key.range || key.range->low < key.range->high);
    EXPECT_TRUE(!key.choices.empty() || (key.type != KeyType::choice && key.type != KeyType::axes));
  }
}

TEST(Schema, UnitStandsAtTheEndOfTheName) {
  const std::pair<std::string, std::string> endings[] = {{"m", "_m"},         {"kg/m^3", "_kg_m3"}, {"Pa", "_pa"},      {"m/s", "_m_s"},
                                                         {"m/s^2", "_m_s2"},  {"deg", "_deg"},      {"s", "_s"},        {"1/s", ""},
                                                         {"min", "_minutes"}, {"Pa s", "_pa_s"},    {"cells", "_cells"}};
  for (const KeyInfo& key : case_reference().keys) {
    if (key.unit.empty()) continue;
    const auto ending = std::find_if(std::begin(endings), std::end(endings), [&](const auto& e) { return e.first == key.unit; });
    ASSERT_NE(ending, std::end(endings)) << key.name << ": unit " << key.unit << " has no ending here";
    EXPECT_TRUE(key.name.ends_with(ending->second)) << key.name << " in " << key.unit;
  }
}

TEST(Schema, KnowsTheLawsThatTheLibraryHas) {
  std::vector<std::string> declared;
  for (const ModelInfo& model : case_reference().models) {
    declared.push_back(model.name);
    for (const std::string& name : model.keys) {
      EXPECT_TRUE(std::any_of(case_reference().keys.begin(), case_reference().keys.end(),
                              [&](const KeyInfo& key) { return key.table == "material" && key.name == name; }))
          << model.name << " uses " << name;
    }
  }
  std::vector<std::string> existing;
  for (const LawInfo& law : all_laws()) existing.push_back(law.name);
  std::sort(declared.begin(), declared.end());
  std::sort(existing.begin(), existing.end());
  EXPECT_EQ(declared, existing);
}

TEST(Schema, ReferenceListsEveryTableKeyAndLaw) {
  const std::string text = config::reference_text(case_reference());
  const auto json = nlohmann::json::parse(config::reference_json(case_reference()));
  std::size_t keys_in_json = 0;
  for (const auto& table : json.at("tables")) keys_in_json += table.at("keys").size();
  EXPECT_EQ(keys_in_json, case_reference().keys.size());
  EXPECT_EQ(json.at("models").size(), case_reference().models.size());
  for (const KeyInfo& key : case_reference().keys) EXPECT_NE(text.find("\n  " + key.name + " "), std::string::npos) << key.name;
  for (const ModelInfo& model : case_reference().models) EXPECT_NE(text.find(model.name), std::string::npos) << model.name;
}

TEST(NearestWord, FindsSwapsOmissionsAndForgottenUnits) {
  const std::vector<std::string> words{"cell_size_m", "cfl", "density_kg_m3", "min_m", "max_m"};
  EXPECT_EQ(nearest_word("cell_szie_m", words), "cell_size_m");
  EXPECT_EQ(nearest_word("cflx", words), "cfl");
  EXPECT_EQ(nearest_word("density", words), "density_kg_m3");
  EXPECT_EQ(nearest_word("max", words), "max_m");
  EXPECT_EQ(nearest_word("mni_m", words), "min_m");
}

TEST(NearestWord, IsSilentWhereNothingIsNear) {
  const std::vector<std::string> words{"cell_size_m", "cfl"};
  EXPECT_EQ(nearest_word("temperature", words), "");
  EXPECT_EQ(nearest_word("", words), "");
  EXPECT_EQ(nearest_word(std::string(100000, 'c'), words), "");  // neither found nor slow
  EXPECT_EQ(nearest_word("cfl", {}), "");
}

}  // namespace
}  // namespace mpm
