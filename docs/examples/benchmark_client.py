"""A small executor for the benchmark (docs/benchmark.md): it plans by breadth-first search whenever the state is not
the one it expects, and acts. Nothing but the standard library; it is measured by

    llmbt experiment score episodes.jsonl "python docs/examples/benchmark_client.py"
"""

import json
import sys
from collections import deque

MOST_STATES = 20_000


def holds(literals, facts):
    return all((x[4:] not in facts) if x.startswith("not ") else (x in facts) for x in literals)


def plan(facts, goals, actions):
    """The names of the actions that lead to one of the goals; None where none do, no names where that is not known."""
    start = frozenset(facts)
    before, queue = {start: None}, deque([start])
    while queue:
        state = queue.popleft()
        if any(holds(goal, state) for goal in goals):
            names = []
            while before[state] is not None:
                state, name = before[state]
                names.append(name)
            return names[::-1]
        if len(before) > MOST_STATES:
            return []
        for name, action in actions.items():
            if holds(action["start"], state) and holds(action["hold"], state):
                after = (state - set(action["deletes"])) | set(action["adds"])
                if after not in before:
                    before[after] = (state, name)
                    queue.append(after)
    return None


def main():
    actions, goals, names, expected = {}, [], [], None
    for line in sys.stdin:
        message = json.loads(line)
        if message["type"] == "result":
            continue
        if message["type"] == "episode":
            actions, goals, names, expected = {}, message["goals"], [], None
        actions.update(message.get("actions", {}))
        facts = frozenset(message["facts"])
        if message["running"]:
            answer = {"do": "wait"}
        elif any(holds(goal, facts) for goal in goals):
            answer = {"do": "end", "verdict": "SUCCESS"}
        else:
            if facts != expected or not names:
                names = plan(facts, goals, actions)
            if not names:
                answer = {"do": "end", "verdict": "UNSOLVABLE" if names is None else "GIVE_UP"}
            else:
                name = names.pop(0)
                expected = (facts - set(actions[name]["deletes"])) | set(actions[name]["adds"])
                answer = {"do": "start", "action": name}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
