"""A grown tree in the user's own process: the tree, its leaves' stubs for C++ and Python, and how to swap versions."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files

from llmbt.exports.names import class_names, function_names, parameter_names
from llmbt_ir.signatures import Signatures

__all__ = ["plugin_files"]


def plugin_files(tree_xml: bytes, signatures: Signatures) -> dict[str, bytes]:
    """The files by name: tree.xml, leaves.hpp, plugin.cpp, main.cpp, CMakeLists.txt, leaves.py, engine.py,
    README.md. The robot's side is to be filled in in leaves.hpp or leaves.py; the rest is done."""
    found = {name: _template(name) for name in ("main.cpp", "CMakeLists.txt", "engine.py", "README.md")}
    found["leaves.hpp"] = _leaves_hpp(signatures)
    found["plugin.cpp"] = _plugin_cpp(signatures)
    found["leaves.py"] = _leaves_py(signatures)
    return {"tree.xml": tree_xml, **{k: v.encode() for k, v in sorted(found.items())}}


def _template(name: str) -> str:
    return (files("llmbt.exports") / "templates" / f"{name}.txt").read_text(encoding="utf-8")


# -- C++ -----------------------------------------------------------------------------------------------------------


def _ports(ports: tuple[str, ...]) -> str:
    return ", ".join(f"BT::InputPort<std::string>({_quoted(p)})" for p in ports)


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


CONDITION = """\
class {name} : public BT::ConditionNode
{{
public:
  using BT::ConditionNode::ConditionNode;
  static BT::PortsList providedPorts()
  {{
    return {{ {ports} }};
  }}
  BT::NodeStatus tick() override
  {{
{reads}    // TODO: whether {shown} holds; answer at once
    return BT::NodeStatus::FAILURE;
  }}
}};
"""
ACTION = """\
class {name} : public Skill
{{
public:
  using Skill::Skill;
  static BT::PortsList providedPorts()
  {{
    return {{ {ports} }};
  }}

private:
  void start() override
  {{
{reads}    // TODO: start {shown} and return at once
  }}
  BT::NodeStatus poll() override
  {{
    // TODO: RUNNING while it goes on, then SUCCESS or FAILURE
    return BT::NodeStatus::FAILURE;
  }}
  void stop() override
  {{
    // TODO: stop, and return when the robot has come to rest
  }}
}};
"""
HEAD = """\
// The leaves of the tree, from its TreeNodesModel. What the robot does goes where it says TODO.
#pragma once

#include <string>

#include "behaviortree_cpp/bt_factory.h"

namespace llmbt
{
// An action of the one robot body. BehaviorTree.CPP starts a new action before it halts the old one in the same tick;
// here the old one is stopped first.
class Skill : public BT::StatefulActionNode
{
public:
  using BT::StatefulActionNode::StatefulActionNode;
  ~Skill() override
  {
    release();
  }
  BT::NodeStatus onStart() final
  {
    if(Skill* other = active(); other != nullptr && other != this)
    {
      other->stop();
    }
    active() = this;
    start();
    return BT::NodeStatus::RUNNING;
  }
  BT::NodeStatus onRunning() final
  {
    if(active() != this)
    {
      return BT::NodeStatus::FAILURE;  // another action took the robot over
    }
    const BT::NodeStatus status = poll();
    if(status != BT::NodeStatus::RUNNING)
    {
      release();
    }
    return status;
  }
  void onHalted() final
  {
    if(active() == this)
    {
      stop();
      release();
    }
  }

protected:
  virtual void start() = 0;
  virtual BT::NodeStatus poll() = 0;
  virtual void stop() = 0;
  std::string port(const char* name)
  {
    const auto value = getInput<std::string>(name);
    if(!value)
    {
      throw BT::RuntimeError("missing port ", name, ": ", value.error());
    }
    return value.value();
  }

private:
  static Skill*& active()
  {
    static Skill* one = nullptr;
    return one;
  }
  void release()
  {
    if(active() == this)
    {
      active() = nullptr;
    }
  }
};

"""


PLUGIN_HEAD = """\
#include "leaves.hpp"

// Loaded by BT::BehaviorTreeFactory::registerFromPlugin.
BT_REGISTER_NODES(factory)
{
"""


def _leaves_hpp(signatures: Signatures) -> str:
    names = _classes(signatures)
    parts = [HEAD]
    for table, text, getter in (
        (signatures.conditions, CONDITION, "getInput<std::string>({port}).value()"),
        (signatures.actions, ACTION, "port({port})"),
    ):
        for leaf, ports in sorted(table.items()):
            variables = parameter_names(ports)
            reads = "".join(
                f"    [[maybe_unused]] const std::string {variables[p]} = {getter.format(port=_quoted(p))};\n"
                for p in ports
            )
            shown = f"{leaf}({', '.join(ports)})" if ports else leaf
            parts.append(text.format(name=names[leaf], ports=_ports(ports), reads=reads, shown=shown) + "\n")
    return "".join([*parts, "}  // namespace llmbt\n"])


def _classes(signatures: Signatures) -> Mapping[str, str]:
    conditions = {n: n for n in sorted(signatures.conditions)}
    actions = {n: n for n in sorted(signatures.actions)}
    found = class_names([*conditions, *actions])
    return {k: (f"{v}_" if v == "Skill" else v) for k, v in found.items()}


def _plugin_cpp(signatures: Signatures) -> str:
    names = _classes(signatures)
    rows = (f"  factory.registerNodeType<llmbt::{names[leaf]}>({_quoted(leaf)});" for leaf in names)
    return PLUGIN_HEAD + "\n".join(rows) + "\n}\n"


# -- Python --------------------------------------------------------------------------------------------------------

PYTHON_HEAD = '''\
"""The leaves of the tree, from its TreeNodesModel. What the robot does goes where it says TODO; see engine.py."""

from __future__ import annotations

from behaviortreepy import NodeStatus


class Robot:
    """A condition answers at once. An action is started, asked until it is done, and stopped."""
'''


def _leaves_py(signatures: Signatures) -> str:
    parts = [PYTHON_HEAD]
    functions = function_names([*sorted(signatures.conditions), *sorted(signatures.actions)])
    for leaf, ports in sorted(signatures.conditions.items()):
        arguments = "".join(f", {p}: str" for p in parameter_names(ports).values())
        parts.append(
            f"\n    def holds_{functions[leaf]}(self{arguments}) -> bool:\n"
            f'        """TODO: whether it holds."""\n        return False\n'
        )
    for leaf, ports in sorted(signatures.actions.items()):
        arguments = "".join(f", {p}: str" for p in parameter_names(ports).values())
        name = functions[leaf]
        parts.append(
            f"\n    def start_{name}(self{arguments}) -> None:\n"
            f'        """TODO: start it and return at once."""\n'
            f"\n    def poll_{name}(self{arguments}) -> NodeStatus:\n"
            f'        """TODO: RUNNING while it goes on, then SUCCESS or FAILURE."""\n'
            f"        return NodeStatus.FAILURE\n"
            f"\n    def stop_{name}(self{arguments}) -> None:\n"
            f'        """TODO: stop, and return when the robot has come to rest."""\n'
        )
    conditions = {n: (f"holds_{functions[n]}", list(p)) for n, p in sorted(signatures.conditions.items())}
    actions = {n: (functions[n], list(p)) for n, p in sorted(signatures.actions.items())}
    parts.append(f"\n\nCONDITIONS = {conditions!r}\nACTIONS = {actions!r}\n")
    return "".join(parts)
