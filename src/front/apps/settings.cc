#include "src/front/apps/settings.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <fstream>
#include <iterator>

// Debian's build of the library throws exceptions; the header-only form does not.
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include "src/base/files/there.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

std::string environment_name(const std::string& prefix, const std::string& key) {
  std::string name = prefix + key;
  for (auto& c : name) c = c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

// Returns the text that a flag with this value would have; no value for tables and other types.
std::optional<std::string> as_text(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* number = node.as_integer()) return std::to_string(number->get());
  if (const auto* toggle = node.as_boolean()) return toggle->get() ? "true" : "false";
  if (const auto* number = node.as_floating_point()) {
    std::array<char, 32> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number->get()).ptr;
    return std::string(buffer.data(), end);
  }
  if (const auto* list = node.as_array()) {
    std::string joined;
    for (const auto& element : *list) {
      const auto text = element.is_array() ? std::nullopt : as_text(element);
      if (!text) return std::nullopt;
      joined += (joined.empty() ? "" : ",") + *text;
    }
    return joined;
  }
  return std::nullopt;
}

}  // namespace

void Settings::set(Setting& setting, Source source, std::string text, std::string origin) {
  if (setting.source > source) return;
  setting.source = source;
  setting.text = std::move(text);
  setting.origin = std::move(origin);
}

void Settings::set_flag(const std::string& key, std::string text) {
  set(settings_.at(key), Source::flag, std::move(text), "--" + key);
}

std::vector<std::string> Settings::environment_names() const {
  std::vector<std::string> names;
  for (const auto& [key, setting] : settings_) {
    if (!setting.flag_only) names.push_back(environment_name(prefix_, key));
  }
  return names;
}

void Settings::load_environment(const std::function<const char*(const char*)>& get_environment) {
  for (auto& [key, setting] : settings_) {
    if (setting.flag_only) continue;
    const auto name = environment_name(prefix_, key);
    if (const char* text = get_environment(name.c_str())) set(setting, Source::environment, text, name);
  }
}

std::vector<std::string> Settings::given() const {
  std::vector<std::string> keys;
  for (const auto& [key, setting] : settings_) {
    if (setting.source != Source::none) keys.push_back(key);
  }
  return keys;
}

Settings::Source Settings::source(const std::string& key) const {
  const auto found = settings_.find(key);
  return found == settings_.end() ? Source::none : found->second.source;
}

std::optional<std::string> Settings::text(const std::string& key) const {
  if (source(key) == Source::none) return std::nullopt;
  return settings_.at(key).text;
}

Result<bool> Settings::on(const std::string& key) const {
  BOOST_OUTCOME_TRY(value, get(key, [](const std::string& text) { return parse_switch(text); }));
  return value.value_or(false);
}

Status Settings::exclusive(const std::string& a, const std::string& b) {
  auto& first = settings_.at(a);
  auto& second = settings_.at(b);
  if (first.source == Source::none || second.source == Source::none) return success();
  if (first.source == second.source) {
    return error(Errc::usage, first.origin + " and " + second.origin + " contradict each other: give one of them");
  }
  (first.source < second.source ? first : second).source = Source::none;
  return success();
}

Status load_settings_file(const std::filesystem::path& path, const std::vector<Settings*>& commands) {
  BOOST_OUTCOME_TRY(bytes, file_bytes(path));
  std::ifstream file(path, std::ios::binary);
  if (!file) return error(Errc::io, path.string() + ": the configuration file cannot be read");
  constexpr std::size_t bytes_max = 1 << 20;  // a thousand times the size of a usual file
  std::string content;
  std::copy_n(std::istreambuf_iterator<char>(file), std::min<std::uint64_t>(bytes, bytes_max),
              std::back_inserter(content));
  const auto at_line = [&](const toml::source_region& source) {
    return path.string() + ", line " + std::to_string(source.begin.line) + ": ";
  };
  const auto parsed = toml::parse(content, path.string());
  if (!parsed) {
    return error(Errc::usage, at_line(parsed.error().source()) + std::string(parsed.error().description()));
  }
  const auto read = [&](Settings& settings, const toml::key& key_node, const toml::node& value) -> Status {
    const std::string key(key_node.str());
    const auto setting = settings.settings_.find(key);
    if (setting == settings.settings_.end()) {
      const std::string where = settings.table().empty() ? "there is" : "[" + settings.table() + "] has";
      return error(Errc::usage, at_line(key_node.source()) + where + " no key '" + key + "'");
    }
    if (setting->second.flag_only) {
      return error(Errc::usage, at_line(key_node.source()) + "'" + key + "' can be given on the command line only");
    }
    const auto text = as_text(value);
    if (!text) {
      return error(Errc::usage,
                   at_line(key_node.source()) + key + ": neither text, number, true, false nor a list of those");
    }
    settings.set(setting->second, Settings::Source::file, *text, at_line(key_node.source()) + key);
    return success();
  };
  const auto of_table = [&](std::string_view name) {
    const auto found = std::find_if(commands.begin(), commands.end(),
                                    [&](const Settings* settings) { return settings->table() == name; });
    return found == commands.end() ? nullptr : *found;
  };
  for (const auto& [key, node] : parsed.table()) {
    const auto* table = node.as_table();
    if (table == nullptr && of_table("")) {
      BOOST_OUTCOME_TRYV(read(*of_table(""), key, node));
      continue;
    }
    Settings* const settings = of_table(key.str());
    if (settings == nullptr || table == nullptr) {
      return error(Errc::usage,
                   at_line(key.source()) + "there is no table [" + std::string(key.str()) +
                       (of_table("") ? "]" : "]; options stand in the table of their command, as in [triangulate]"));
    }
    for (const auto& [key_node, value] : *table) {
      BOOST_OUTCOME_TRYV(read(*settings, key_node, value));
    }
  }
  return success();
}

}  // namespace tessera::apps
