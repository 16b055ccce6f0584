// The folders that may hold inputs, and the files in them that a job's inputs mean.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/service/inputs/look_beneath.h"

namespace tessera::service {

// An entry of a folder below a root, which a job may name.
struct RootEntry {
  std::string name;  // its name as an input: files() finds this entry by it
  FoundBeneath found;
};

// Error usage when the data folder and a folder of inputs contain each other: jobs could then read files of other
// callers, and remove their own inputs. A root that does not exist is reported when it is opened. Error io.
Status check_apart(const std::filesystem::path& data, const std::vector<std::filesystem::path>& roots);

class Roots {
 public:
  // `uploads` is the folder of uploads, or empty when uploads are off. Error io for a root that is no folder.
  static Result<Roots> open(const std::vector<std::filesystem::path>& roots, const std::filesystem::path& uploads);

  // The files that these inputs mean, in the order of find_inputs() (src/input/cloud). Inputs are files, folders and
  // patterns, absolute or relative to a root (the first root in which they are found), or "upload:NAME/FILE". Each file
  // was opened below its root and is a regular file; its real path is returned, once. Errors: usage for an input that
  // leads out of the roots, for a pattern with "..", for standard input and for addresses that the process does not
  // open (src/input/bytes/objects.h); io for a missing file; those of Objects::names(); those of the thread's ledger
  // (src/base/ledger.h), from which each name that is looked at is drawn. An address stands for objects, which are
  // returned by their names, and opened later.
  Result<std::vector<std::string>> files(const std::vector<std::string>& inputs, bool recursive) const;

  // The sentence with the files in these folders named as callers name them: relative to the root, or
  // "upload:NAME/FILE".
  std::string named(std::string sentence) const;

  // The entries of a folder, sorted by name: files with the ending of a point format, and folders that are no results;
  // no hidden ones, and none that lead out of the roots. "" lists all roots and the folders of uploads. Only the folder
  // is opened for reading. Errors: usage for a folder that leads out of the roots, for "..", and for one that is
  // missing or no folder; those of the thread's ledger.
  Result<std::vector<RootEntry>> list(const std::string& folder) const;

 private:
  struct Root {
    std::filesystem::path given, real;
    FileHandle folder;
  };
  static Result<Root> open_root(const std::filesystem::path& path);
  Result<std::vector<std::string>> files_of(const std::string& input, bool recursive) const;
  static Status add_entries(const Root& root, const std::string& folder, const std::string& begin,
                            std::vector<RootEntry>& entries);

  std::vector<Root> roots_;
  std::vector<Root> uploads_;  // at most one
};

}  // namespace tessera::service
