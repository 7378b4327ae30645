#pragma once
// `tiltfeed support-bundle`: what somebody needs who is to help, in one file that can be read before it is
// sent.

#include <memory>
#include <string>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the command to the command line; after it is parsed, runs it.
class SupportCommand {
 public:
  SupportCommand(CLI::App& app, const std::string& version);
  ~SupportCommand();
  SupportCommand(const SupportCommand&) = delete;
  SupportCommand& operator=(const SupportCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 the file is written, 1 it is not, 2 wrong use.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
