// The options of one command, from three sources: flag > environment > configuration file.
// Every source gives text. The typed getters parse the text, and their errors name the source:
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

namespace tessera::apps {

class Settings {
 public:
  enum class Source : std::uint8_t { none, file, environment, flag };  // a later one wins

  // `table`: the table of the configuration file that this command reads, "triangulate"; "": the keys outside of
  // tables. `prefix`: the beginning of the names of its variables.
  explicit Settings(std::string table, std::string prefix = "TESSERA_")
      : table_(std::move(table)), prefix_(std::move(prefix)) {}
  const std::string& table() const { return table_; }

  // Declares a key, for --key, TESSERA_KEY (in capitals, _ for -) and `key = ` in the file. flag_only: for --key alone.
  void declare(const std::string& key, bool flag_only = false) { settings_[key].flag_only = flag_only; }
  bool knows(const std::string& key) const { return settings_.contains(key); }
  // Returns the TESSERA_* variables that load_environment() reads, sorted.
  std::vector<std::string> environment_names() const;

  // These do not replace a value that a stronger source has set. REQUIRES for set_flag(): the key is declared.
  void set_flag(const std::string& key, std::string text);
  void load_environment(const std::function<const char*(const char*)>& get_environment);

  // Returns the keys for which some source has a value, sorted.
  std::vector<std::string> given() const;
  Source source(const std::string& key) const;
  std::optional<std::string> text(const std::string& key) const;

  // Returns the value of `key`, parsed by `parse`; no value if no source has one. Errors: those of `parse`, with the
  // name of the source.
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
  // Returns whether a switch is on. A switch that no source has is off.
  Result<bool> on(const std::string& key) const;

  // For two keys that contradict each other: keeps only the one from the stronger source. Error usage if both come from
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

// Reads a TOML file with one table for each command. Keys outside of tables are for the command with the table "", if
// there is one. Errors name file and line: io if the file cannot be read; usage if the file is not TOML, or has a table
// or key that no command knows, or a value that is no string, number, boolean or list of those.
Status load_settings_file(const std::filesystem::path& path, const std::vector<Settings*>& commands);

}  // namespace tessera::apps
