#include "daemon/command/submission.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "config/job.h"
#include "daemon/command/command.h"
#include "daemon/command/interrupt.h"
#include "daemon/plan/plan_program.h"

namespace tiltfeed::daemon {

Result<Submission> Submission::open(const std::string& file) {
  Submission made;
  const std::size_t dot = file.rfind('.'), slash = file.rfind('/');
  const std::string ending = dot == file.npos ? "" : file.substr(dot);
  made.program = ending == ".nc" || ending == ".ngc" || ending == ".gcode" || ending == ".tap";
  const std::size_t begin = slash == file.npos ? 0 : slash + 1;
  made.name = file.substr(begin, dot == file.npos || dot < begin ? file.npos : dot - begin);
  std::vector<std::string> paths{file};
  bool names_tool = false;
  if (!made.program) {
    const PromptEnd prompt_end;                                 // a job may be a pipe that nobody writes
    const auto operations = config::load_operations(file, {});  // says at once what is wrong with it
    if (!operations) return tl::unexpected<Error>(operations.error());
    const config::Job& planned = operations->front();
    if (const Result<void> whole = goes_alone(planned); !whole) return tl::unexpected<Error>(whole.error());
    paths.push_back(planned.stl_path);
    for (const config::Job& one : *operations) names_tool = names_tool || !one.tools_path.empty();
  }
  for (const std::string& path : paths) {
    const int fd = names_tool && made.files.empty() ? open_written_out(path)
                                                    : ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) return fail(Code::kIo, path + ": " + std::strerror(errno));
    made.files.push_back(fd);
    struct stat now {};
    if (::fstat(fd, &now) == 0 && S_ISREG(now.st_mode) && now.st_size == 0)
      return fail(Code::kInput, path + ": is empty, there is nothing to send");
  }
  return made;
}

Submission::~Submission() {
  for (const int fd : files) ::close(fd);
}

}  // namespace tiltfeed::daemon
