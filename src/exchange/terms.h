// Terms of the coordinators of one run. Each coordinator claims the next term, and the highest term is obeyed, even
// when a coordinator that was believed dead goes on.
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/result.h"
#include "src/exchange/epoch.h"

namespace tessera {

// Claims the next term: 1, 2, ... No two callers, on whatever machine, get the same term. Error io.
Result<Term> claim_term(const std::filesystem::path& run);
// Removes the records of claimed terms below `below`. A record that cannot be removed stays. Error io when the records
// cannot be listed.
Status forget_terms(const std::filesystem::path& run, Term below);
// Returns whether a higher term was claimed. Returns false when that cannot be found out now.
bool is_replaced(const std::filesystem::path& run, Term term);

// Returns an id of a routed run that is the same for every process and differs from those of all other runs, in this
// folder or elsewhere. Error io.
Result<JobId> identity_of(const std::filesystem::path& run);

}  // namespace tessera
