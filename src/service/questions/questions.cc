#include "src/service/questions/questions.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <stop_token>

#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/base/ledger.h"
#include "src/base/random_token.h"
#include "src/base/stopped.h"
#include "src/job/arguments.h"
#include "src/job/version.h"
#include "src/service/beneath.h"
#include "src/service/deadline.h"
#include "src/service/live/live_answers.h"
#include "src/service/live/live_results.h"
#include "src/service/naming.h"
#include "src/service/problem.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/table.h"

namespace tessera::service {
namespace {

// Errors name files of the result as the caller knows them, however the files were opened (path_of()).
Error in_callers_words(Error failed, const std::string& folder, const std::string& name) {
  const std::string handle = "/proc/self/fd/", known = "triangulation '" + name + "'";
  std::string& said = failed.where;
  for (std::size_t at = 0; at < said.size(); ++at) {
    std::size_t end = at;
    if (said.compare(at, handle.size(), handle) == 0)
      end = std::min(said.find_first_not_of("0123456789", at + handle.size()), said.size());
    else if (said.compare(at, folder.size(), folder) == 0)
      end = at + folder.size();
    if (end == at) continue;
    const bool inside = end < said.size() && said[end] == '/';
    said.replace(at, end - at + (inside ? 1 : 0), known + (inside ? ", " : ""));
  }
  return failed;
}

proto::Problem no_triangulation(std::string_view name) {
  return problem(404, "there is no triangulation '" + std::string(name) + "'", Errc::usage);
}

// 0: the newest.
Result<std::uint32_t> version_asked(const Question& question) {
  const auto found = question.options.find("version");
  if (found == question.options.end()) return 0U;
  const auto number = parse_integer(found->second, 1, std::numeric_limits<std::uint32_t>::max());
  if (!number) return error(number.error().code, "version: " + number.error().where);
  return static_cast<std::uint32_t>(number.value());
}

}  // namespace

Status Questions::open() {
  const auto folder = answers_folder(data_);
  BOOST_OUTCOME_TRYV(remove_whole(folder));
  return make_directories(folder);
}

Reply<std::string> Questions::identity(std::string_view name) {
  const auto held = results_.find(name);
  if (!held) return problem_of(held.error());
  if (!held.value()) return no_triangulation(name);
  if (live_ && live_->find(name)) return std::string();
  return held.value()->identity + "-" + version();
}

Reply<QuestionAnswer> Questions::ask(const Question& question) {
  const std::string& name = question.triangulation;
  const auto missing = [&]() -> std::optional<proto::Problem> {
    const auto there = results_.exists(name);
    if (!there) return problem_of(there.error());
    if (!there.value()) return no_triangulation(name);
    return std::nullopt;
  };
  if (const auto none = missing()) return *none;
  const auto version = version_asked(question);
  if (!version) return problem_of(version.error());
  auto opened = readers_.open(name, version.value());
  if (!opened) {
    if (const auto none = missing()) return *none;
    return problem_of(in_callers_words(opened.error(), results_.folder(name).string(), name));
  }
  const auto& reader = *opened.value();
  // One version answers the whole question: the newest one in memory, or the one that is stored.
  const KeptLive* kept = live_ ? live_->find(name) : nullptr;
  const bool in_memory = kept && version.value() == 0 && is_answered_in_memory(question);
  const auto newest = in_memory ? kept->current() : nullptr;
  const auto stored_number = kept ? kept->number_of(reader.stored.manifest().version) : std::nullopt;
  const auto folder = TemporaryFolder::make(answers_folder(data_) / random_token());
  if (!folder) return problem_of(folder.error());
  Ledger ledger({.disk = {limits_.answer_bytes, "an answer"}, .memory = {limits_.memory_bytes / 8, "a question"}});
  const std::function<void()> stop = [&] { ledger.stop(); };
  const std::stop_callback caller_gone(question.stop, stop), result_gone(reader.gone.get_token(), stop);
  const Deadline deadline(ledger, limits_.time, time_is_over(limits_.time));
  const Ledger::Use use(&ledger);
  auto answer = [&]() -> Result<QuestionAnswer> {
    try {
      OpenQuestion open(reader, question, limits_, folder.value().path(), ledger.token());
      open.live = newest.get();
      return service::answer(open);
    } catch (const Stopped& stopped) {
      return error(Errc::interrupted, stopped.what());
    }
  }();
  if (answer) {
    const std::uint64_t stored = reader.stored.manifest().version;
    answer.value().version = newest ? newest->number() : stored_number.value_or(stored);
    return std::move(answer).value();
  }
  // An error that follows from the removal is no damage.
  if (reader.gone.stop_requested())
    return problem(410, "triangulation '" + name + "' was removed while the question was being answered", Errc::usage);
  if (const auto reason = ledger.reason()) return problem_of(*reason);
  return problem_of(in_callers_words(answer.error(), results_.folder(name).string(), name));
}

}  // namespace tessera::service
