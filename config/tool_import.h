#pragma once
// Tools of other programs as entries of a tool library.

#include <string>
#include <vector>

#include "config/tool_entry.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::config {

/// Reads a tool table of LinuxCNC (.tbl), a tool bit or library of FreeCAD (.fctb, .fctl) or a library of
/// Fusion 360 (.json). Properties: each tool is right as an entry of a library; ids differ; what the file
/// says of a tool and the entry does not is in the notes. Errors: kInput with file and place, kIo, kUsage.
Result<ToolImport> import_tools(const std::string& path, const ImportOptions& options);

/// The text of a library with these tools, `remark` above them. parse_tool_library() reads it back as them.
std::string tool_library_text(const std::vector<ToolEntry>& tools, const std::string& remark);

}  // namespace tiltfeed::config
