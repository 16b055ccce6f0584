// The folders in which inputs may lie, and the files in them that a job's inputs mean.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/service/look_beneath.h"

namespace tessera {

// In a folder below a root: what a job may name.
struct RootEntry {
  std::string name;  // that means it as an input: files() finds this one
  FoundBeneath found;
};

// Error usage when the data folder and a folder of inputs lie in one another: jobs could read what belongs to others,
// and remove what they were given. A root that is not there is left to who opens it. Error io.
Status check_apart(const std::filesystem::path& data, const std::vector<std::filesystem::path>& roots);

class Roots {
 public:
  // `uploads` is the folder of uploads, or empty when none are taken. Error io for one that is no folder.
  static Result<Roots> open(const std::vector<std::filesystem::path>& roots, const std::filesystem::path& uploads);

  // The files that these inputs mean, as find_inputs() (src/input/cloud) orders them: files, folders and patterns,
  // absolute or from a root on (the first in which they are found), or "upload:NAME/FILE". Each was opened below its
  // root, is a regular file, and is given by its real path, once. Errors: usage for one that leads out of the roots,
  // for a pattern with "..", for standard input and for addresses; io for one that is not there; of the thread's ledger
  // (src/base/ledger.h), from which each name that is looked at is drawn.
  Result<std::vector<std::string>> files(const std::vector<std::string>& inputs, bool recursive) const;

  // A sentence with the files in these folders named as callers name them: from the root on, or "upload:NAME/FILE".
  std::string named(std::string sentence) const;

  // What a folder holds, sorted by name: files whose name is that of a format we read, and folders that are no results,
  // hidden ones left out, and what leads out of the roots. "": of all roots, and the folders of uploads. Nothing is
  // opened for reading but the folder. Errors: usage for one that leads out of the roots, for "..", and for one that is
  // no folder or not there; of the thread's ledger.
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
  std::vector<Root> uploads_;  // one or none
};

}  // namespace tessera
