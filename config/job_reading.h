#pragma once
// The sections of a job one by one, for those that read a job and for those that ask which keys it may have.

#include <string>

#include "config/section.h"

namespace tiltfeed::config {

struct Job;          // config/job.h
struct ToolLibrary;  // config/tool_library.h

/// The root of a job's text, or of one of its operations. Requires: as Section.
Section job_root(const YamlNode& tree, Complaint& complaint);
/// What the text says of one operation; part, machine and library are not opened. `tools`: as read_cutter();
/// its number is in program.tool where the tool has one. Null: none.
Job read_job(const Section& root, const std::string& path, const ToolLibrary* tools);
/// `operation_order` is by_tool.
bool reads_by_tool(const Section& root);

}  // namespace tiltfeed::config
