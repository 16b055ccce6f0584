// Coordinators of one run, one after the other: each claims the next term, and the highest is obeyed. Also when one
// that was believed dead goes on.
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/result.h"
#include "src/exchange/epoch.h"

namespace tessera {

// Of all who claim, on whatever machine, each gets another one: 1, 2, ... Error io.
Result<Term> claim_term(const std::filesystem::path& run);
// Removes what says of terms below this one that they were claimed. What cannot be removed stays.
// Error io when they cannot be listed.
Status forget_terms(const std::filesystem::path& run, Term below);
// Whether somebody has claimed a higher one.
bool is_replaced(const std::filesystem::path& run, Term term);

// Tells a routed run from any other one, at this place or elsewhere, whichever process asks. Error io.
Result<JobId> identity_of(const std::filesystem::path& run);

}  // namespace tessera
