// Tests modbus_device on virtual time. The client of libmodbus plays the master.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>

#include <arpa/inet.h>
#include <modbus/modbus.h>
#include <sys/socket.h>
#include <unistd.h>

#include <takt/testing.hpp>

#include <basic.hpp>

#include "../common/basic_values.hpp"
#include "../common/beside_threads.hpp"

namespace {

using namespace std::chrono_literals;
using common::flag;
using common::number;
using takt::testing::Module;

/// A socket that listens on a free port of the loopback interface.
class Listener {
 public:
  Listener() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* any = reinterpret_cast<sockaddr*>(&address);
    if (::bind(socket_, any, size) != 0 || ::listen(socket_, 1) != 0 ||
        ::getsockname(socket_, any, &size) != 0)
      throw std::runtime_error("found no free TCP port");
    port = ntohs(address.sin_port);
  }
  ~Listener() { ::close(socket_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  int port = 0;

 private:
  int socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
};

constexpr const char* kMap = R"(
  lamp        out coil 0 safe 0
  speed       out register 10 scale 0.001 unit m/s safe 0
  button      in  discrete 3
  temperature in  input-register 4 int16 scale 0.1 unit degC
)";

class ModbusDevice : public ::testing::Test {
 protected:
  ModbusDevice() {
    EXPECT_TRUE(module.set("map", kMap));
    EXPECT_TRUE(module.set("port", std::to_string(port)));
  }
  template <class Done>
  bool comes(Done&& done) {
    return common::comes_in_time(module, done);
  }
  void connect() { ASSERT_EQ(modbus_connect(master.get()), 0) << modbus_strerror(errno); }

  int port = Listener{}.port;
  Module module{{.period = 10ms}};
  std::unique_ptr<modbus_t, void (*)(modbus_t*)> master{modbus_new_tcp("127.0.0.1", port),
                                                        [](modbus_t* context) {
                                                          modbus_close(context);
                                                          modbus_free(context);
                                                        }};
};

TEST_F(ModbusDevice, AnswersReadsWithTheValuesOfItsInputPorts) {
  ASSERT_TRUE(module.initialize());
  auto& button = module.in<basic::Flag>("button");
  auto& temperature = module.in<basic::Number>("temperature");
  ASSERT_TRUE(module.start());
  connect();
  button.write(flag(true));
  temperature.write(number(-21.5));
  ASSERT_TRUE(comes([&] {
    std::uint8_t bit = 0;
    std::uint16_t word = 0;
    return modbus_read_input_bits(master.get(), 3, 1, &bit) == 1 && bit == 1 &&
           modbus_read_input_registers(master.get(), 4, 1, &word) == 1 &&
           word == static_cast<std::uint16_t>(-215);
  }));
}

TEST_F(ModbusDevice, PublishesTheValuesThatAMasterWrites) {
  ASSERT_TRUE(module.initialize());
  auto& lamp = module.out<basic::Flag>("lamp");
  auto& speed = module.out<basic::Number>("speed");
  auto& clients = module.out<basic::Count>("clients");
  auto& requests = module.out<basic::Count>("requests");
  ASSERT_TRUE(module.start());
  connect();
  ASSERT_EQ(modbus_write_bit(master.get(), 0, 1), 1);
  ASSERT_EQ(modbus_write_register(master.get(), 10, 1250), 1);
  ASSERT_TRUE(comes([&] { return lamp.has_value() && speed.has_value(); }));
  EXPECT_TRUE(lamp.value().value());
  EXPECT_NEAR(speed.value().value(), 1.25, 1e-9);
  EXPECT_EQ(clients.value().value(), 1);
  EXPECT_EQ(requests.value().value(), 2);
  module.step(100);
  EXPECT_EQ(lamp.count(), 1U) << "the device wrote the output although no master wrote";
}

TEST_F(ModbusDevice, RejectsAddressesOutsideTheMap) {
  ASSERT_TRUE(module.start());
  connect();
  std::uint16_t word = 0;
  EXPECT_EQ(modbus_read_input_registers(master.get(), 5, 1, &word), -1);
  EXPECT_EQ(errno, EMBXILADD);
  EXPECT_EQ(modbus_write_bit(master.get(), 1, 1), -1);
  EXPECT_EQ(errno, EMBXILADD);
  EXPECT_EQ(modbus_read_input_registers(master.get(), 4, 1, &word), 1)
      << "a read of an address in the map failed";
}

TEST_F(ModbusDevice, AppliesSafeValuesWhenNoMasterWrites) {
  ASSERT_TRUE(module.set("watchdog", "0.2"));
  ASSERT_TRUE(module.initialize());
  auto& lamp = module.out<basic::Flag>("lamp");
  ASSERT_TRUE(module.start());
  connect();
  ASSERT_EQ(modbus_write_bit(master.get(), 0, 1), 1);
  ASSERT_TRUE(comes([&] { return lamp.has_value() && lamp.value().value(); }));
  EXPECT_TRUE(comes([&] { return !lamp.value().value(); }));
}

TEST_F(ModbusDevice, ExitsIfItsTcpPortIsInUse) {
  const Listener taken;
  ASSERT_TRUE(module.set("port", std::to_string(taken.port)));
  testing::internal::CaptureStderr();
  EXPECT_THAT(module.start().text(), testing::HasSubstr("main() returned 1"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::HasSubstr("cannot listen on 127.0.0.1:" + std::to_string(taken.port)));
}

}  // namespace
