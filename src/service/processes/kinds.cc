#include "src/service/processes/kinds.h"

#include "src/service/processes/table.h"

namespace tessera::service {
namespace {

// The inputs of the process alone; null when there are none.
const google::protobuf::Message* chosen(const proto::Inputs& inputs) {
  const auto* field = proto::Inputs::descriptor()->FindFieldByNumber(inputs.of_case());
  return field == nullptr ? nullptr : &inputs.GetReflection()->GetMessage(inputs, field);
}

const google::protobuf::FieldDescriptor* field_of(const google::protobuf::Message* message, const char* name) {
  return message == nullptr ? nullptr : message->GetDescriptor()->FindFieldByName(name);
}

std::string text_of(const proto::Inputs& inputs, const char* name) {
  const auto* message = chosen(inputs);
  const auto* field = field_of(message, name);
  return field == nullptr ? "" : message->GetReflection()->GetString(*message, field);
}

bool is_on(const proto::Inputs& inputs, const char* name) {
  const auto* message = chosen(inputs);
  const auto* field = field_of(message, name);
  return field != nullptr && message->GetReflection()->GetBool(*message, field);
}

bool makes(const proto::Inputs& inputs, Process::Makes what) {
  const Process* process = find_process(process_of(inputs));
  if (process == nullptr) return false;
  if (process->makes != Process::Makes::change) return process->makes == what;
  if (is_on(inputs, "dry_run")) return what == Process::Makes::nothing;
  return what == (text_of(inputs, "output").empty() ? Process::Makes::columns : Process::Makes::result);
}

}  // namespace

std::string process_of(const proto::Inputs& inputs) {
  const auto* field = proto::Inputs::descriptor()->FindFieldByNumber(inputs.of_case());
  return field == nullptr ? "" : field->name();
}

bool makes_result(const proto::Inputs& inputs) { return makes(inputs, Process::Makes::result); }

bool changes_result(const proto::Inputs& inputs) { return makes(inputs, Process::Makes::columns); }
std::string result_output(const proto::Inputs& inputs) { return makes_result(inputs) ? text_of(inputs, "output") : ""; }

std::optional<std::string> export_output(const proto::Inputs& inputs) {
  const Process* process = find_process(process_of(inputs));
  if (process == nullptr || process->makes != Process::Makes::file) return std::nullopt;
  std::string given = text_of(inputs, "output");
  return given.empty() && process->usual_output != nullptr ? process->usual_output(inputs) : given;
}

std::string result_read(const proto::Inputs& inputs) { return text_of(inputs, "triangulation"); }

std::string second_result_read(const proto::Inputs& inputs) {
  return makes_result(inputs) ? result_read(inputs) : text_of(inputs, "second");
}

std::uint32_t version_read(const proto::Inputs& inputs) {
  const auto* message = chosen(inputs);
  const auto* field = field_of(message, "version");
  return field == nullptr ? 0 : message->GetReflection()->GetUInt32(*message, field);
}

bool overwrites(const proto::Inputs& inputs) { return is_on(inputs, "overwrite"); }

}  // namespace tessera::service
