// Options in sentences. Code that writes a sentence does not know how an option was given: as a flag of the command, a
// keyword argument, a member of a struct, or a field of JSON. So the sentence has a mark with the option's key, and the
// mark is replaced by a name where the sentence is shown (src/front/apps/words.cc, src/front/api/words.cc,
// python/tessera/_errors.py).
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

// Returns the mark of an option. `key` is the name in the command without leading dashes: "memory", "skip-invalid".
// REQUIRES: key matches [a-z][a-z0-9-]*. A mark begins with a NUL, which no path can contain. So no file name is
// mistaken for a mark.
std::string option(std::string_view key);
// Returns the mark of an option with a value: "true" or "false" for a switch, "2", "vtu". REQUIRES: value matches
// [a-z0-9.-]+.
std::string option(std::string_view key, std::string_view value);

// Returns the name of an option. `value` is empty when the option alone is meant.
using OptionName = std::function<std::string(std::string_view key, std::string_view value)>;

// Returns `sentence` with each mark replaced by what `name` returns. A NUL that begins no mark becomes a space, so the
// result has no NUL.
std::string render(std::string_view sentence, const OptionName& name);

// Renders marks for programs without names of their own, such as tests: "memory is too small", "overwrite=true replaces
// it".
std::string in_plain_words(std::string_view sentence);

// Returns the keys of the options in `sentence`, each once, in order of appearance.
std::vector<std::string> option_keys(std::string_view sentence);

}  // namespace tessera
