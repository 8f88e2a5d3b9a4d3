// A library that is no component.
extern "C" void walk();
extern "C" void walk() {}
