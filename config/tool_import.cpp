#include "config/tool_import.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "config/json_tree.h"
#include "config/tool_readers.h"

namespace tiltfeed::config {
namespace {

constexpr std::size_t kMostFileBytes = 64u << 20;  // makers' whole catalogues have ten
constexpr std::size_t kLongestId = 40, kLongestText = 200;

/// A name as an id may be: [A-Za-z0-9._-].
std::string as_id(const std::string& name) {
  std::string id;
  for (const char c : name) {
    const bool plain = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
                       c == '.' || c == '_' || c == '-';
    if (plain)
      id += c;
    else if (!id.empty() && id.back() != '-')
      id += '-';
  }
  if (id.size() > kLongestId) id.resize(kLongestId);
  while (!id.empty() && id.back() == '-') id.pop_back();
  return id;
}

/// The first of the names that there is, made unlike all before.
std::string new_id(const ToolEntry& tool, std::set<std::string>& taken) {
  std::string id = as_id(tool.id);
  if (id.empty()) id = as_id(tool.name);
  if (id.empty()) id = as_id(tool.product);
  if (id.empty()) id = tool.number > 0 ? "T" + std::to_string(tool.number) : "tool";
  std::string free = id;
  for (int i = 2; !taken.insert(free).second; ++i) {
    const std::string ending = "-" + std::to_string(i);
    free = id.substr(0, kLongestId - ending.size()) + ending;
  }
  return free;
}

/// At most so many bytes, cut between letters, and nothing that is no UTF-8.
std::string short_text(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::size_t size = byte < 0x80                   ? 1
                             : byte >= 0xF0 && byte < 0xF5 ? 4
                             : byte >= 0xE0                ? 3
                             : byte >= 0xC2                ? 2
                                                           : 0;
    bool whole = size > 0 && byte < 0xF5 && i + size <= text.size();
    for (std::size_t k = 1; whole && k < size; ++k)
      whole = (static_cast<unsigned char>(text[i + k]) & 0xC0) == 0x80;
    if (out.size() + size > kLongestText) break;
    out += whole ? text.substr(i, size) : "?";
    i += whole ? size : 1;
  }
  return one_line(out);
}

/// What the library's reader has against a tool; empty: nothing.
std::string trouble_with(const ToolEntry& tool) {
  const auto read = parse_tool_library(tool_library_text({tool}, ""), "");
  if (read) return "";
  // Its place is one in a text that nobody sees: ":4:5: tools[1].length_mm: ...".
  const std::string message = read.error().message.substr(0, read.error().message.find('\n'));
  const std::size_t key = message.find("tools[1].");
  return key == message.npos ? message : message.substr(key + 9);
}

void finish(ToolImport& import) {
  std::set<std::string> taken;
  std::vector<ToolEntry> kept;
  for (ToolEntry& tool : import.tools) {
    tool.name = short_text(tool.name), tool.vendor = short_text(tool.vendor),
    tool.product = short_text(tool.product);
    for (CuttingData& data : tool.data) data.material = short_text(data.material);
    tool.id = new_id(tool, taken);
    if (const std::string trouble = trouble_with(tool); !trouble.empty())
      import.notes.push_back(tool.id + ": left out: " + trouble);
    else
      kept.push_back(std::move(tool));
  }
  import.tools = std::move(kept);
}

}  // namespace

Result<std::string> read_tool_file(const std::string& path) {
  std::error_code failed;
  const auto size = std::filesystem::file_size(path, failed);
  std::ifstream in(path, std::ios::binary);
  if (failed || !in) return fail(Code::kIo, path + ": cannot be read");
  if (size > kMostFileBytes)
    return fail(Code::kInput, path + ": " + std::to_string(size) + " bytes; expected at most " +
                                  std::to_string(kMostFileBytes));
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Result<ToolImport> import_tools(const std::string& path, const ImportOptions& options) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  const bool table = ending == ".tbl", bit = ending == ".fctb", library = ending == ".fctl";
  if (ending == ".tools" || ending == ".hsmlib")
    return fail(Code::kUsage, path + ": Fusion 360 writes this form packed; export the library as JSON");
  if (!table && !bit && !library && ending != ".json")
    return fail(Code::kUsage,
                path + ": expected .tbl (LinuxCNC), .fctb or .fctl (FreeCAD) or .json (Fusion 360)");
  if (options.unit_mm && !table)
    return fail(Code::kUsage, path + ": states its units itself; --unit is for .tbl");
  const Result<std::string> text = read_tool_file(path);
  if (!text) return tl::unexpected(text.error());
  Result<ToolImport> import = table     ? read_linuxcnc_tools(*text, path, options)
                              : bit     ? read_freecad_bit(*text, path)
                              : library ? read_freecad_library(*text, path)
                                        : read_fusion_tools(*text, path);
  if (!import) return import;
  if (import->tools.size() > kMostLibraryTools)
    return fail(Code::kInput, path + ": " + std::to_string(import->tools.size()) +
                                  " tools; a library has at most " + std::to_string(kMostLibraryTools));
  finish(*import);
  return import;
}

}  // namespace tiltfeed::config
