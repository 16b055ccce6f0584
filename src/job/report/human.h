// Numbers as people read them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tessera {

std::string human_count(std::uint64_t n);                     // "999", "12.3 k", "4.56 M"
std::string human_bytes(std::uint64_t bytes);                 // "512 B", "1.5 GiB"
std::string human_seconds(double seconds);                    // "0.42 s", "12 s", "3 min 04 s", "2 h 05 min"
std::string grouped(std::uint64_t n);                         // "12 345 678"
std::string counted(std::uint64_t n, std::string_view what);  // `what`: the singular
std::string fixed(double value, int digits);                  // with a decimal point in every locale
std::string coordinate(double value);                         // up to ten digits: "770500.25"
// Returns what the phase of that name does, in plain words; the name itself if there is no such phase.
std::string plain_phase(std::string_view name);
std::string escape_html(std::string_view text);  // & < > " '; bytes that are not UTF-8 become U+FFFD

}  // namespace tessera
