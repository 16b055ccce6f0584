#include "src/service/jobs/kept_inputs.h"

#include <google/protobuf/descriptor.h>

#include <span>

#include "src/base/files/checksum.h"
#include "src/job/report/human.h"
#include "src/service/problem.h"
#include "src/service/processes/kinds.h"

namespace tessera::service {
namespace {

// Smaller records, which are most, are not changed.
constexpr std::size_t small_bytes = 1 << 10, text_bytes_max = 256;

}  // namespace

std::optional<proto::Problem> check_size(const proto::Inputs& inputs) {
  const std::uint64_t bytes = inputs.ByteSizeLong();
  if (bytes <= inputs_bytes_max) return std::nullopt;
  return problem(413,
                 process_of(inputs) + ": the inputs of the job take " + human_bytes(bytes) + ", and at most " +
                     human_bytes(inputs_bytes_max) + " are allowed: name folders or patterns instead of files",
                 Errc::memory);
}

std::string sum_of(const proto::Inputs& inputs) {
  const std::string bytes = inputs.SerializeAsString();
  return checksum_text(checksum(std::as_bytes(std::span(bytes))));
}

bool same_inputs(const proto::JobRecord& job, const proto::Inputs& inputs) {
  if (!job.inputs_sum().empty()) return job.inputs_sum() == sum_of(inputs);
  return job.inputs().SerializeAsString() == inputs.SerializeAsString();
}

void drop_inputs(proto::JobRecord& job) {
  if (job.inputs().ByteSizeLong() <= small_bytes) return;
  if (job.inputs_sum().empty()) job.set_inputs_sum(sum_of(job.inputs()));
  auto& inputs = *job.mutable_inputs();
  const auto* kind = proto::Inputs::descriptor()->FindFieldByNumber(inputs.of_case());
  if (kind == nullptr) return;
  auto& of_kind = *proto::Inputs::GetReflection()->MutableMessage(&inputs, kind);
  const auto& type = *of_kind.GetDescriptor();
  const auto& access = *of_kind.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const auto* field = type.field(i);
    const bool long_text = !field->is_repeated() &&
                           field->cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_STRING &&
                           access.GetString(of_kind, field).size() > text_bytes_max;
    if (field->is_repeated() || long_text) access.ClearField(&of_kind, field);
  }
}

}  // namespace tessera::service
