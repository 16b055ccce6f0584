#include "src/exchange/terms.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <string>
#include <system_error>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"

namespace tessera {
namespace {

template <class Each>
Status for_each_term(const std::filesystem::path& run, const Each& each) {
  FolderReader reader(terms_folder(run));
  while (const char* name = reader.next()) {
    std::uint32_t term = 0;
    const char* const last = name + std::strlen(name);
    const auto [end, wrong] = std::from_chars(name, last, term);
    if (wrong == std::errc{} && end == last) each(Term{term});
  }
  if (reader.error() && reader.error() != std::errc::no_such_file_or_directory)
    return io_error(terms_folder(run), "cannot be listed", reader.error().value());
  return success();
}

Result<Term> highest_term(const std::filesystem::path& run) {
  Term highest;
  BOOST_OUTCOME_TRYV(for_each_term(run, [&](Term term) { highest = std::max(highest, term); }));
  return highest;
}

}  // namespace

Result<Term> claim_term(const std::filesystem::path& run) {
  BOOST_OUTCOME_TRYV(make_directories(terms_folder(run)));
  BOOST_OUTCOME_TRY(highest, highest_term(run));
  while (++highest.value != 0) {
    const auto folder = terms_folder(run) / to_string(highest);
    if (::mkdir(folder.c_str(), 0777) == 0) return highest;  // a folder that was there before is another claim
    if (errno != EEXIST) return io_error(folder, "cannot be made", errno);
  }
  return error(Errc::io, terms_folder(run).string() +
                             ": the highest possible term is in use, so no further coordinator can take the job");
}

Status forget_terms(const std::filesystem::path& run, Term below) {
  std::vector<Term> old;
  BOOST_OUTCOME_TRYV(for_each_term(run, [&](Term term) {
    if (term < below) old.push_back(term);
  }));
  for (const Term term : old) ::rmdir((terms_folder(run) / to_string(term)).c_str());
  return success();
}

bool is_replaced(const std::filesystem::path& run, Term term) {
  const auto highest = highest_term(run);  // an error counts as no: the caller asks again later
  return highest && highest.value() > term;
}

Result<JobId> identity_of(const std::filesystem::path& run) {
  const auto plan = plan_file(run);
  struct stat found {};
  if (::stat(plan.c_str(), &found) != 0) return io_error(plan, "cannot be looked at", errno);
  const std::array<std::uint64_t, 4> what = {found.st_ino, static_cast<std::uint64_t>(found.st_mtim.tv_sec),
                                             static_cast<std::uint64_t>(found.st_mtim.tv_nsec),
                                             static_cast<std::uint64_t>(found.st_size)};
  return JobId{checksum(std::as_bytes(std::span(what)))};
}

}  // namespace tessera
