// From what a user names to the files that are meant.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/spool.h"

namespace tessera {

struct InputName {
  std::string path;
  bool standard_input = false;
  // What stands before and behind a sentence about this input: "list.txt, line 3: " and where it was found.
  std::string before = {}, behind = {};

  Error explained(const Error& error) const { return {error.code, before + error.where + behind}; }
};

struct InputQuestion {
  std::vector<std::string> patterns = {};  // files, folders, patterns like "block/*.las", "-" for standard input
  std::string list = {};                   // a file with one such (but "-") a line, or "-"; they follow `patterns`
  bool recursive = false;                  // folders with their subfolders
};

// The files, those of a pattern or a folder sorted by bytes: the order gives the points their ids, so no locale may
// change it. A folder stands for the files in it whose name is that of a format we read, hidden ones left out. In a
// list, lines that are blank or begin with '#' are skipped, and relative paths begin at the list's folder. Errors:
// nothing matches, no such file in a folder, a result folder, standard input twice.
Result<std::vector<InputName>> find_inputs(const InputQuestion& question, Spool& spool);

// Whether a triangulation, or a part of one, is in this folder.
Result<bool> is_result_folder(const std::filesystem::path& folder);

}  // namespace tessera
