#include "src/service/http/sessions.h"

#include <algorithm>
#include <span>
#include <sstream>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/service/http/secrets.h"

namespace tessera::service::http {
namespace {

constexpr std::size_t session_bytes = 32, checksum_digits = 64;

std::int64_t seconds(Sessions::Clock::time_point time) {
  return std::chrono::duration_cast<std::chrono::seconds>(time.time_since_epoch()).count();
}

bool is_checksum(const std::string& text) {
  return text.size() == checksum_digits && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

Status Sessions::load(Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  if (file_.empty()) return success();
  BOOST_OUTCOME_TRY(kept_any, is_there(file_));
  if (!kept_any) return success();
  BOOST_OUTCOME_TRY(bytes, read_whole(file_));
  std::istringstream text{std::string(as_text(bytes))};
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::istringstream words(line);
    std::string session, more;
    Kept kept;
    if (!(words >> session >> kept.mark >> kept.ends_s) || words >> more || !is_checksum(session) ||
        !is_checksum(kept.mark))
      return error(Errc::usage, file_.string() + ", line " + std::to_string(number) +
                                    ": is no session; if you remove the file, everybody must sign in again");
    if (kept.ends_s > seconds(now)) kept_[session] = std::move(kept);
  }
  return success();
}

Result<std::string> Sessions::begin(std::string_view mark, Clock::time_point now) {
  std::string session = random_hex(session_bytes);
  const std::scoped_lock lock(mutex_);
  std::erase_if(kept_, [&](const auto& entry) { return entry.second.ends_s <= seconds(now); });
  const auto own = [&](const auto& entry) { return entry.second.mark == mark; };
  if (static_cast<std::size_t>(std::count_if(kept_.begin(), kept_.end(), own)) >= of_a_token_max) {
    auto oldest = kept_.end();
    for (auto at = kept_.begin(); at != kept_.end(); ++at)
      if (own(*at) && (oldest == kept_.end() || at->second.ends_s < oldest->second.ends_s)) oldest = at;
    kept_.erase(oldest);
  }
  const auto at = kept_.emplace(checksum_of_secret(session), Kept{std::string(mark), seconds(now + lifetime)}).first;
  if (const Status written = write(); !written) {
    kept_.erase(at);
    return written.error();
  }
  return session;
}

std::optional<std::string> Sessions::find(std::string_view session, Clock::time_point now) const {
  const std::string checksum = checksum_of_secret(session);
  const std::scoped_lock lock(mutex_);
  const auto found = kept_.find(checksum);
  if (found == kept_.end() || found->second.ends_s <= seconds(now)) return std::nullopt;
  return found->second.mark;
}

Status Sessions::end(std::string_view session) {
  const std::string checksum = checksum_of_secret(session);
  const std::scoped_lock lock(mutex_);
  return kept_.erase(checksum) > 0 ? write() : success();
}

Status Sessions::end_unless(const std::function<bool(const std::string& mark)>& known) {
  const std::scoped_lock lock(mutex_);
  const auto gone = std::erase_if(kept_, [&](const auto& entry) { return !known(entry.second.mark); });
  return gone > 0 ? write() : success();
}

Status Sessions::write() const {
  if (file_.empty()) return success();
  std::string text;
  for (const auto& [session, kept] : kept_)
    text += session + " " + kept.mark + " " + std::to_string(kept.ends_s) + "\n";
  return write_private(file_, std::as_bytes(std::span(text)));
}

}  // namespace tessera::service::http
