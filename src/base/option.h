// Options in sentences. Who writes a sentence does not know how an option was given: as a flag of the command, a
// keyword argument, a member of a struct, a field of JSON. It is marked by its key, and named where the sentence is
// shown (src/front/apps/words.cc, src/front/api/words.cc, python/tessera/_errors.py).
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

// `key`: as in the command, without dashes before it: "memory", "skip-invalid". [a-z][a-z0-9-]*
// A mark begins with a NUL, which no path can hold: no name of a file is taken for one.
std::string option(std::string_view key);
// The same, given this value: "true" and "false" of a switch, "2", "vtu". [a-z0-9.-]+
std::string option(std::string_view key, std::string_view value);

// What an option is called; `value` is empty when the option alone is meant.
using OptionName = std::function<std::string(std::string_view key, std::string_view value)>;

// `sentence` with `name` in the place of each mark. A NUL that begins no mark becomes a space: the result holds none.
std::string render(std::string_view sentence, const OptionName& name);

// For programs without names of their own, benchmarks and tests: "memory is too small", "overwrite=true replaces it".
std::string in_plain_words(std::string_view sentence);

// The keys of the options that `sentence` names, each once, in their order.
std::vector<std::string> option_keys(std::string_view sentence);

}  // namespace tessera
