#include "src/service/inputs/inputs.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>

#include "src/base/crs/crs.h"
#include "src/base/printable.h"
#include "src/input/cloud/cloud.h"
#include "src/input/format.h"
#include "src/service/deadline.h"
#include "src/service/naming.h"
#include "src/service/problem.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

constexpr std::chrono::seconds headers_time{5};  // for reading headers; further entries come without

std::optional<proto::Problem> no_uploads(const Uploads* uploads) {
  if (uploads != nullptr) return std::nullopt;
  return problem(
      403,
      "this service takes no uploads; its operator can allow them (uploads), or put the files into a folder for inputs",
      Errc::usage);
}

// Reads the header of a file. `real` is the path of the file, below one of the roots.
void look_into(const Roots& roots, const fs::path& real, const std::stop_token& stop, proto::InputInfo& into) {
  const auto cloud = Cloud::open({real.string()}, {.dimension = 0}, stop);
  if (!cloud) {
    into.set_note(printable(roots.named(cloud.error().where)));  // callers need not know where the roots are
    return;
  }
  for (const FileInfo& file : cloud.value().files()) {
    into.set_format(file.format);
    if (file.points) into.set_points(*file.points);
    if (file.bounds && !file.bounds->empty())
      for (const Point& corner : {file.bounds->lo, file.bounds->hi})
        for (int axis = 0; axis < file.dimension; ++axis) into.add_bounds(corner[axis]);
  }
  if (!cloud.value().crs().empty()) into.set_crs(printable(crs_title(cloud.value().crs())));
}

}  // namespace

Reply<proto::InputList> Inputs::list(std::string_view folder, std::uint32_t limit, std::string_view after,
                                     const Caller& caller) {
  if (caller.role < Role::submit) return problem(403, "listing input files needs a token of role submit", Errc::usage);
  WhileAnyoneWaits waited(caller.stop);
  auto entries = roots_.list(std::string(folder));
  if (!entries) return problem_of_inputs(waited.ledger().reason().value_or(entries.error()));
  // A name that JSON cannot hold cannot be an input of a job.
  std::erase_if(entries.value(), [](const RootEntry& each) { return printable(each.name) != each.name; });
  proto::InputList list;
  list.set_folder(std::string(folder));
  list.set_number_matched(entries.value().size());
  const auto begun = std::chrono::steady_clock::now();
  for (const RootEntry& entry : entries.value()) {
    if (entry.name <= after) continue;
    if (static_cast<std::uint32_t>(list.inputs_size()) >= limit) break;
    proto::InputInfo& info = *list.add_inputs();
    info.set_name(entry.name);
    info.set_modified(time_of_file(entry.found.modified_s));
    info.set_folder(entry.found.kind == KindBeneath::folder);
    if (info.folder()) continue;
    info.set_bytes(entry.found.bytes);
    const fs::path unpacked = without_packing(entry.name);
    info.set_format(unpacked.extension().string().substr(1));
    // Packed files would have to be unpacked.
    if (unpacked != fs::path(entry.name) || std::chrono::steady_clock::now() - begun > headers_time) continue;
    look_into(roots_, entry.found.real, waited.ledger().token(), info);
    if (const auto over = waited.ledger().reason()) return problem_of_inputs(*over);
  }
  return list;
}

Reply<std::unique_ptr<Upload>> Inputs::upload(std::string_view folder, std::string_view file, std::uint64_t offset,
                                              const Caller& caller) {
  if (const auto refused = no_uploads(uploads_)) return *refused;
  if (caller.role < Role::submit) return problem(403, "sending an upload needs a token of role submit", Errc::usage);
  return uploads_->begin(folder, file, offset, caller);
}

Reply<std::uint64_t> Inputs::uploaded(std::string_view folder, std::string_view file) {
  if (const auto refused = no_uploads(uploads_)) return *refused;
  return uploads_->uploaded(folder, file);
}

Reply<void> Inputs::remove_upload(std::string_view folder, std::string_view file, const Caller& caller) {
  if (const auto refused = no_uploads(uploads_)) return *refused;
  if (caller.role < Role::submit) return problem(403, "removing an upload needs a token of role submit", Errc::usage);
  return uploads_->remove(folder, file, caller);
}

}  // namespace tessera::service
