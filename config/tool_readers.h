#pragma once
// The readers behind import_tools(), one for each program. Their entries are not checked yet, and their ids
// are names as the file has them.

#include <string>

#include "config/tool_entry.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::config {

/// The text of a user's file, at most 64 MiB. Errors: kIo; kInput.
Result<std::string> read_tool_file(const std::string& path);

Result<ToolImport> read_linuxcnc_tools(const std::string& text, const std::string& path,
                                       const ImportOptions& options);
/// One tool bit.
Result<ToolImport> read_freecad_bit(const std::string& text, const std::string& path);
/// A library: a list of tool bits, which lie beside it or in a folder Bit beside it or its folder.
Result<ToolImport> read_freecad_library(const std::string& text, const std::string& path);
Result<ToolImport> read_fusion_tools(const std::string& text, const std::string& path);

}  // namespace tiltfeed::config
