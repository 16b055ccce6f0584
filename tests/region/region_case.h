// A random question to a random cloud, and whether the answer is right.
#pragma once

#include <cstdint>
#include <string>

namespace tessera::testing_region {

// Makes a cloud, cuts it into units, and asks for several regions; each answer is compared, as a set of cells of source
// indices, with the cells of CGAL's triangulation of the whole cloud that meet the region, and each part of an answer
// that a limit cut short must say truly which of its cells are final. Everything depends on `seed` alone. "" or what is
// wrong; `regions` grows by the number of them, `unread` by those for which something was left unread.
std::string check_case(std::uint64_t seed, std::uint64_t& regions, std::uint64_t& unread);

}  // namespace tessera::testing_region
