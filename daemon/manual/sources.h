#pragma once
// What the pages are made from: the command line, commented YAML files, Markdown.

#include <string>
#include <vector>

#include "config/command_line.h"
#include "daemon/manual/page.h"

namespace tiltfeed::daemon {

/// `name`: as it is called, "tiltfeed machine". `deep`: with all that is below it; else its commands are
/// named only.
Page command_page(const config::Command& command, const std::string& name, bool deep);
/// A file whose comments say what each key is; `name` and `what` as of Page.
Page keys_page(const std::string& name, const std::string& what, const std::string& text);
/// Headings, paragraphs, lists, tables and blocks of source; what is after a link's text is left out.
Page markdown_page(const std::string& name, const std::string& what, const std::string& text);

/// A text of this repository, as it was when the program was built: config/tools/example.yaml,
/// config/service.yaml, config/desk.yaml, daemon/service/API.md, daemon/wire/MODBUS.md,
/// daemon/post/CONTROLS.md. Empty: no such.
const char* shipped_text(const std::string& path);

struct Topic {
  std::string name;  ///< of `tiltfeed help NAME`
  Page page;
};
/// Files and protocols.
std::vector<Topic> topics();

}  // namespace tiltfeed::daemon
