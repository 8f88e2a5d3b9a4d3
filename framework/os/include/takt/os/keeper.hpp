// takt-keeper, which ends a program together with all processes that the program has started.
#pragma once

namespace takt::os {

/// The program of takt-keeper. It starts a program, and ends all processes that the program has started when
/// the program or its node ends. Only Child::spawn() starts takt-keeper, with these arguments:
///
///     takt-keeper FAILURE STATUS COPY NAME=VALUE... -- PROGRAM [ARGUMENT...]
///
/// FAILURE is a pipe that gets the error number if the program cannot be executed. STATUS is a pipe that gets
/// a KeptStart, and later a KeptEnd. COPY is the file to execute instead of PROGRAM, or -1.
int keep(int count, char** arguments);

/// What takt-keeper writes when it has started the program.
struct KeptStart {
  int pid = 0;
};

/// What takt-keeper writes when no process of the program is left. The program itself remains a zombie until
/// SIGTERM ends takt-keeper, so its PID is not used again before.
struct KeptEnd {
  int signalled = 0;
  int code = 0;  ///< as in ProcessEnd
  int left_others = 0;
};

}  // namespace takt::os
