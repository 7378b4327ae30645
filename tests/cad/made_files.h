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

/// A job of such a file. `keys`: of its part, each with a comma before it; `more`: axis, pattern and so on.
inline std::string cad_job(const std::string& file, const std::string& keys, const std::string& cutter,
                           const std::string& more) {
  return "part: {name: part, stl: " + cad_file(file) + keys + "}\ncutter: " + cutter + "\n" + more + R"yaml(
tolerance_mm: 0.01
clearance_mm: 5
approach_mm: 1
feeds: {cut_mm_per_min: 2000, plunge_mm_per_min: 600}
setup: {part_zero_mm: [0, 0, 100]}
machine: )yaml" +
         SOURCE_DIR + "/config/machines/generic-ac.yaml\n";
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
