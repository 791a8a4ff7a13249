#pragma once
/// The tables and keys of a kind of file; components declare the keys (base/parameter.hpp). Schema is independent of the components: it
/// accesses the object that a file fills through a `void*`, and SchemaOf<Root> adds its type. By it objects are written as TOML, compared
/// and hashed; reader.hpp reads them.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "libmpm/base/parameter.hpp"

namespace mpm {

/// One key as a user sees it.
struct KeyInfo : ParameterInfo {
  std::string table;          ///< empty: above the first table
  std::string default_text;   ///< as TOML, or the effect of omitting the key; empty for a required key
  std::string required_when;  ///< empty: never; "always", or the condition
  std::string used_when;      ///< empty: always; elsewhere the key is refused
};

using KeyType = ParameterType;  ///< of the value of a key

}  // namespace mpm

namespace mpm::config {

using Value = ParameterValue;  ///< of a key

/// A key, with access to its value in entry i of its table.
struct Key : KeyInfo {
  std::function<std::optional<Value>(const void* root, std::size_t i)> get;  ///< empty: left out
  std::function<void(void* root, std::size_t i, const Value&)> set;          ///< the value has the right type
};

/// A table of a file, with access to the component that it fills.
struct Table {
  std::string name;                                                              ///< empty: the keys above the first table
  bool repeated;                                                                 ///< [[name]], any number of times
  std::string description;                                                       ///< one line
  std::vector<Key> keys;                                                         ///< in the order in which they are written
  std::function<std::size_t(const void* root)> entries;                          ///< number of entries
  std::function<void(void* root)> add_entry;                                     ///< adds an entry
  std::function<void(const void* root, std::size_t i, ParameterReport&)> check;  ///< checks conditions within an entry

  /// "[[body]]"
  [[nodiscard]] std::string bracketed() const { return repeated ? "[[" + name + "]]" : "[" + name + "]"; }
  /// Path of an entry: "body[0]", "numerics"
  [[nodiscard]] std::string entry_path(std::size_t i) const { return repeated ? name + "[" + std::to_string(i) + "]" : name; }
};

/// "numerics.cfl", "body[0].min_m", "title"
[[nodiscard]] std::string key_path(const std::string& table_path, const std::string& name);

/// Which defaults a file holds: all, or those that are not hidden. The hash of a case is of the latter, so that a new key leaves it as it
/// is.
enum class Defaults : std::uint8_t { all, shown };

/// The schema of a file, independent of the type that the file fills.
class Schema {
 public:
  std::string command = "mpm schema";  ///< prints the reference of the keys; for messages

  [[nodiscard]] const std::vector<Table>& tables() const { return tables_; }               ///< in the order in which they are written
  [[nodiscard]] const Table* find(std::string_view table) const;                           ///< null for an unknown table
  [[nodiscard]] const Key* find_key(std::string_view table, std::string_view name) const;  ///< null for an unknown key
  /// The keys that set the same quantity as this one ("conveyor.froude_number"): only one of them may be given.
  [[nodiscard]] std::vector<std::string> rivals(const std::string& path) const;

  /// Whether a condition is met in entry i of a table.
  [[nodiscard]] bool holds(const Condition& condition, const Table& table, const void* root, std::size_t i) const;
  /// Whether entry i may have this key.
  [[nodiscard]] bool used(const Key& key, const Table& table, const void* root, std::size_t i) const {
    return holds(key.used, table, root, i);
  }
  /// The value to write; empty for a key that is not used, left out, or has a default that is not to be written.
  [[nodiscard]] std::optional<Value> written(const Key& key, const Table& table, const void* root, std::size_t i, Defaults defaults) const;

 protected:
  /// An empty table at the end.
  Table& add(std::string name, bool repeated, std::string description);
  /// Fills in the texts of a key.
  static void describe(KeyInfo& key, const std::string& table);

 private:
  std::vector<Table> tables_;
};

/// The schema of files that fill a Root.
template <class Root>
class SchemaOf : public Schema {
 public:
  /// @param member  of Root, that the table fills: a component, a std::optional of it (the table may be left out), or a std::vector (a
  ///                repeated table)
  template <class Member>
  void table(std::string name, std::string description, Member Root::*member) {
    if constexpr (requires(Member m) { m.emplace_back(); }) {
      table(std::move(name), std::move(description), [member](auto& root) { return &(root.*member); });
    } else {
      table(
          std::move(name), std::move(description), [member](auto& root) -> auto& { return root.*member; });
    }
  }
  /// @param access  [](auto& root) -> auto& of the component that the table fills, or of a std::optional of it; for a repeated table a
  ///                pointer to its std::vector (null: entries are not possible)
  template <class Access>
  void table(std::string name, std::string description, Access access) {
    using Part = std::remove_cvref_t<decltype(access(std::declval<Root&>()))>;
    if constexpr (std::is_pointer_v<Part>) {
      repeated<typename std::remove_pointer_t<Part>::value_type>(std::move(name), std::move(description), access);
    } else if constexpr (requires(Part p) { p.emplace(); }) {
      Table& made = fill<typename Part::value_type>(
          add(std::move(name), false, std::move(description)), [access](auto& root, std::size_t) -> auto& { return *access(root); });
      made.entries = [access](const void* root) -> std::size_t { return access(as_root(root)) ? 1 : 0; };
      made.add_entry = [access](void* root) { access(as_root(root)).emplace(); };
    } else {
      Table& made = fill<Part>(
          add(std::move(name), false, std::move(description)), [access](auto& root, std::size_t) -> auto& { return access(root); });
      made.entries = [](const void*) -> std::size_t { return 1; };
      made.add_entry = [](void*) {};
    }
  }

 private:
  static const Root& as_root(const void* root) { return *static_cast<const Root*>(root); }
  static Root& as_root(void* root) { return *static_cast<Root*>(root); }

  template <class Owner, class Access>
  void repeated(std::string name, std::string description, Access access) {
    Table& made = fill<Owner>(
        add(std::move(name), true, std::move(description)), [access](auto& root, std::size_t i) -> auto& { return (*access(root))[i]; });
    made.entries = [access](const void* root) -> std::size_t {
      const auto* list = access(as_root(root));
      return list != nullptr ? list->size() : 0;
    };
    made.add_entry = [access](void* root) { access(as_root(root))->emplace_back(); };
  }

  /// @param at  (root, i) -> the component
  template <class Owner, class At>
  static Table& fill(Table& made, At at) {
    for (const Parameter<Owner>& p : parameters_of<Owner>().all()) {
      Key& key = made.keys.emplace_back();
      static_cast<ParameterInfo&>(key) = p.info;
      key.get = [at, get = p.get](const void* root, std::size_t i) { return get(at(as_root(root), i)); };
      key.set = [at, set = p.set](void* root, std::size_t i, const Value& value) { set(at(as_root(root), i), value); };
      describe(key, made.name);
    }
    made.check = [at]([[maybe_unused]] const void* root, [[maybe_unused]] std::size_t i, [[maybe_unused]] ParameterReport& report) {
      if constexpr (requires(const Owner& owner) { owner.check(report); }) at(as_root(root), i).check(report);
    };
    return made;
  }
};

/// Every key that applies, as a file that reads back to the same object. @param skip  keys that are left out ("table.name")
[[nodiscard]] std::string write(const Schema& schema, const void* root, Defaults defaults, const std::vector<std::string>& skip = {});

/// One key, "table.key" or "body[0].key", as text: a number as in `write`, a string without its quotes. Empty if it is not written.
[[nodiscard]] std::optional<std::string> value_of(const Schema& schema, const void* root, const std::string& path);

/// The keys in which two objects differ: "numerics.cfl was 0.4, is 0.3", "body[1].shape was "box", is (none)".
[[nodiscard]] std::vector<std::string> differences(const Schema& schema, const void* before, const void* now,
                                                   const std::vector<std::string>& skip);

/// FNV-1a, 64 bit.
[[nodiscard]] std::uint64_t hash(std::string_view text);

}  // namespace mpm::config
