// The options of one command, from three sources: flag > environment > configuration file.
// Every source gives text; the typed getters parse it and name the source when it is wrong:
// "--threads: 'x' ...", "TESSERA_THREADS: ...", "tessera.toml, line 4: threads: ...".
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/result.h"

namespace tessera {

class Settings {
 public:
  enum class Source : std::uint8_t { none, file, environment, flag };  // a later one wins

  // `table`: the table of the configuration file that this command reads, "triangulate"; "": what stands in none.
  // `prefix`: of its variables.
  explicit Settings(std::string table, std::string prefix = "TESSERA_")
      : table_(std::move(table)), prefix_(std::move(prefix)) {}
  const std::string& table() const { return table_; }

  // Declares the key of --key, TESSERA_KEY (in capitals, _ for -) and `key = ` in the file. flag_only: in --key alone.
  void declare(const std::string& key, bool flag_only = false) { settings_[key].flag_only = flag_only; }
  bool knows(const std::string& key) const { return settings_.contains(key); }
  // The TESSERA_* variables that load_environment() asks for, in order.
  std::vector<std::string> environment_names() const;

  // Each ignores what a stronger source has set already. REQUIRES: set_flag: the key is declared.
  void set_flag(const std::string& key, std::string text);
  void load_environment(const std::function<const char*(const char*)>& get_environment);

  // The keys that some source has, in order.
  std::vector<std::string> given() const;
  Source source(const std::string& key) const;
  std::optional<std::string> text(const std::string& key) const;

  // The value of `key` as `parse` reads it, or nothing when no source has it.
  template <class Parse>
  auto get(const std::string& key, Parse parse) const
      -> Result<std::optional<typename decltype(parse(std::string()))::value_type>> {
    using Value = typename decltype(parse(std::string()))::value_type;
    const auto found = settings_.find(key);
    if (found == settings_.end() || found->second.source == Source::none) return std::optional<Value>{};
    auto value = parse(found->second.text);
    if (!value) return error(value.error().code, found->second.origin + ": " + value.error().where);
    return std::optional<Value>{std::move(value).value()};
  }
  // A switch is off when no source has it.
  Result<bool> on(const std::string& key) const;

  // Of two keys that contradict each other only the one from the stronger source stays. Error usage when both come from
  // the same source.
  Status exclusive(const std::string& a, const std::string& b);

 private:
  friend Status load_settings_file(const std::filesystem::path& path, const std::vector<Settings*>& commands);
  struct Setting {
    bool flag_only = false;
    Source source = Source::none;
    std::string text;
    std::string origin;  // how an error names the source
  };
  void set(Setting& setting, Source source, std::string text, std::string origin);

  std::string table_, prefix_;
  std::map<std::string, Setting> settings_;
};

// Reads a TOML file with one table a command, and no keys outside unless one has the table "". Errors name file and
// line: io when it cannot be read; usage when it is not TOML, or has a table or key that no command knows, or a value
// that is no string, number, boolean or list of those.
Status load_settings_file(const std::filesystem::path& path, const std::vector<Settings*>& commands);

}  // namespace tessera
