// The table of processes.
#pragma once

#include <google/protobuf/descriptor.h>

#include <span>
#include <string_view>

#include "src/service/processes/process.h"

namespace tessera::service {

// In the order of documents.
std::span<const Process* const> all_processes();
// Null when there is none of this name.
const Process* find_process(std::string_view name);
// The member of the inputs' oneof; its type is the message of the process's inputs.
const google::protobuf::FieldDescriptor& member_of(const Process& process);

// Does a job of any process, as Process::run() says. The job draws from `work.ledger`; when it meets a bound, its
// problem names the bound.
Reply<JobDone> do_work(const Workshop& shop, const JobWork& work);

}  // namespace tessera::service
