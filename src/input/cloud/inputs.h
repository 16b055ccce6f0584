// Finds the files that a user's names mean.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/spool.h"

namespace tessera {

// An input that was found.
struct InputName {
  std::string path;
  bool standard_input = false;
  // Texts around a sentence about this input: before it "list.txt, line 3: ", behind it where the input was found.
  std::string before = {}, behind = {};

  Error explained(const Error& error) const { return {error.code, before + error.where + behind}; }
};

// What a user names.
struct InputQuestion {
  // files, folders, patterns such as "block/*.las", and "-" for standard input
  std::vector<std::string> patterns = {};
  std::string list = {};   // a file, or "-", with one more of these (except "-") on each line
  bool recursive = false;  // look into subfolders of folders
};

// Returns the input files in order: `patterns`, then `list`. The files of one pattern or folder are sorted by bytes.
// This order gives points their ids, so no locale may change it. A folder stands for the files in it whose names are
// those of formats that can be read, without hidden files. A folder with an ept.json stands for that cloud alone. In a
// list, blank lines and lines that begin with '#' are skipped, and relative paths begin at the list's folder. Errors:
// no file matches; no such file is in a folder; the folder is a result; standard input is named twice.
Result<std::vector<InputName>> find_inputs(const InputQuestion& question, Spool& spool);

// Whether a folder has a triangulation, or a part of one, in it.
Result<bool> is_result_folder(const std::filesystem::path& folder);

}  // namespace tessera
