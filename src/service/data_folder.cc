#include "src/service/data_folder.h"

#include <chrono>
#include <cstring>
#include <string>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/mixed_bits.h"
#include "src/exchange/terms.h"
#include "src/service/data_format.h"
#include "src/service/processes/costs.h"
#include "src/service/service.h"

namespace tessera::service {
namespace {

// Some of the newest of these folders stay, so that a slow daemon cannot claim a term again.
constexpr std::uint32_t terms_kept = 100;

// A file that only reserves room. A daemon that starts on a full disk frees it for a lock, a term and records. Then it
// can serve results, and remove them when asked to.
constexpr std::uint64_t reserve_bytes = std::uint64_t{1} << 20;

Status give_back_reserve(const std::filesystem::path& data) {
  if (free_bytes(data) >= reserve_bytes) return success();
  return remove_file(data_reserve_file(data));
}

// Called when there is room again. Errors are ignored.
void keep_reserve(const std::filesystem::path& data) {
  const auto there = is_there(data_reserve_file(data));
  if (!there || there.value() || free_bytes(data) < 4 * reserve_bytes) return;
  std::string bytes(reserve_bytes, '\0');  // random, so that no file system compresses the file
  for (std::size_t i = 0; i + sizeof(std::uint64_t) <= bytes.size(); i += sizeof(std::uint64_t)) {
    const std::uint64_t mixed = mixed_bits(i);
    std::memcpy(bytes.data() + i, &mixed, sizeof mixed);
  }
  static_cast<void>(write_whole(data_reserve_file(data), bytes));
}

}  // namespace

Result<std::unique_ptr<DataFolder>> DataFolder::hold(const ServiceOptions& options) {
  BOOST_OUTCOME_TRYV(make_directories(options.data));
  BOOST_OUTCOME_TRYV(give_back_reserve(options.data));
  const LockOptions how{.heartbeat = options.data_lease / 12,
                        .silence_max = options.data_lease,
                        .lost = options.lost,
                        .locked = options.locked};
  auto lock = FolderLock::take(options.data, how);
  // Not usage: the other process ends some time, so trying again makes sense.
  if (!lock) return error(lock.error().code == Errc::usage ? Errc::io : lock.error().code, lock.error().where);
  std::unique_ptr<DataFolder> held(new DataFolder(std::move(lock).value()));
  BOOST_OUTCOME_TRYV(check_data_format(options.data));
  BOOST_OUTCOME_TRY(term, claim_term(options.data));
  BOOST_OUTCOME_TRYV(forget_terms(options.data, Term{term.value < terms_kept ? 0 : term.value - terms_kept}));
  BOOST_OUTCOME_TRYV(make_directories(jobs_folder(options.data)));
  const auto lay = [&](const std::filesystem::path& area, std::unique_ptr<StagingFolder>& desk) -> Status {
    BOOST_OUTCOME_TRYV(make_directories(area));
    BOOST_OUTCOME_TRY(laid, StagingFolder::lay(area, term.value, [held = held.get()] { return held->still_ours(); }));
    desk = std::move(laid);
    return success();
  };
  BOOST_OUTCOME_TRYV(lay(options.data, held->jobs_));
  BOOST_OUTCOME_TRYV(lay(results_folder(options.data), held->results_));
  BOOST_OUTCOME_TRYV(lay(uploads_folder(options.data), held->uploads_));
  keep_reserve(options.data);
  return held;
}

}  // namespace tessera::service
