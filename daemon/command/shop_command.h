#pragma once
// `tiltfeed shop`: the shop's queue, seen and kept in order by people.

#include <memory>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the command to the command line; after it is parsed, runs it.
class ShopCommand {
 public:
  explicit ShopCommand(CLI::App& app);
  ~ShopCommand();
  ShopCommand(const ShopCommand&) = delete;
  ShopCommand& operator=(const ShopCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
