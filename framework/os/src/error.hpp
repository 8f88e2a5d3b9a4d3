// Converts error numbers of the kernel into problems.
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace takt::os {

/// Returns a problem for the present errno, for example "CALL: No such file or directory".
Problem errno_problem(std::string call, std::string fix = {});
/// Returns a problem for an error number. If the process has too many open files (EMFILE), the problem
/// advises to raise the limit, and `fix` is not used.
Problem error_problem(std::string call, int error, std::string fix = {});
/// Returns what a user can do if a file or folder cannot be written because of this error number.
std::string advice_to_write(int error);

}  // namespace takt::os
