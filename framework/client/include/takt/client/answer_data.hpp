// Reads the JSON in the answers of nodes. A node may be of another version, and any program on the network
// may answer. So no part of an answer may be used before it is checked.
#pragma once

#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/core/result.hpp>

namespace takt::client {

/// Calls `read` with the JSON in the answer of a device. `read` must access members only with functions that
/// throw nlohmann::json::exception if the member is missing or has another type: at(), get(), and value() of
/// an object. If `read` throws an exception, read_answer() fails, and the problem names the device.
Result<void> read_answer(const std::string& device, const std::string& data,
                         const std::function<void(const nlohmann::ordered_json&)>& read);

/// Returns the status report of a device from one of its answers. Throws nlohmann::json::exception if the
/// report lacks a member that each report has, or if one of its members has another type than in the output
/// of `takt status --json`.
nlohmann::ordered_json checked_report(const nlohmann::ordered_json& report);

/// Returns the description of a device's modules from its answer to COMMAND_DESCRIBE: a list of objects, each
/// with the "name" of a module, and with lists "ports" and "properties" of objects that have a "name". Fails
/// if `data` is not such an answer.
Result<nlohmann::ordered_json> described_modules(const std::string& device, const std::string& data);

}  // namespace takt::client
