// Converts error numbers of the kernel into problems.
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace takt::os {

/// Returns a problem for the current errno, for example "CALL: No such file or directory".
Problem errno_problem(std::string call, std::string fix = {});
/// Returns a problem for an error number. If the error is that the process has too many open files, a fix for
/// that replaces `fix`.
Problem error_problem(std::string call, int error, std::string fix = {});

}  // namespace takt::os
