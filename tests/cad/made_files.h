#pragma once
// The CAD files of tests/cad/cad_files.cpp, made once for each process.

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/texts/folder.h"

namespace tiltfeed {

/// The path of a file that cad_files writes.
inline std::string cad_file(const std::string& name) {
  static const Folder folder("cad_files");
  static const int made = std::system((std::string(BINARY_DIR) + "/bin/cad_files " + folder.path).c_str());
  EXPECT_EQ(made, 0);
  return folder.path + "/" + name;
}

/// The text with the first `from` after the first `after` changed to `to`.
inline std::string changed(std::string text, const std::string& after, const std::string& from,
                           const std::string& to) {
  const std::size_t at = text.find(from, text.find(after));
  EXPECT_NE(at, text.npos) << after << " " << from;
  if (at != text.npos) text.replace(at, from.size(), to);
  return text;
}

}  // namespace tiltfeed
