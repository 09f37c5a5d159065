## The playground: a simulated monitor in a web page.

# What a field of a frame means.
field-start = Start of the frame: a sync byte and the frame mark
field-receiver = Address of the receiver on the bus
field-sender = Address of the sender; the answer goes to it
field-request = { $title } (§{ $section })
field-addressee = Addressee: { $title }
field-answerer = Who answers: { $title }
field-no-status = Without meaning in a request
field-data-size = Number of data bytes that follow
field-data-unknown = Data that the protocol does not describe
field-crc16 = CRC-16/MODBUS of everything from the receiver’s address on
field-crc32c = CRC-32C of everything from the receiver’s address on
field-end = End of the frame: the frame mark
escaped = { $meaning } (a byte that looks like a frame mark or an escape is sent as two)
request-unknown = A request that the document does not know
subsystem-unknown = a subsystem that the document does not know
status-unknown = A status that the document does not know
ampere = A
celsius = °C
atmosphere = atm

# Where the way of a request ends.
end-cut-short = The record is cut short: { $what }. Nothing of it is executed.
end-closed = General looks first and lets nothing of this kind pass now: the monitor is locked out, or about to restart.
end-unknown = The document does not know this request: General answers.
end-nobody = “{ $to }” may not be asked for this: General answers.
end-everyone = Each subsystem that handles the request answers for itself, in the order of the chain.
end-absent = “{ $to }” is not part of this monitor: the answer says so.
end-not-addressee = “{ $to }” may not be asked for this: it refuses.
end-intercepted = “{ $by }” intercepts the request to “{ $to }”: its state contradicts it.
end-data = “{ $to }” gets the request, but cannot read its data.
end-reached = No subsystem objects: “{ $to }” gets the request and answers itself.

# What was done.
done-break = Fault: { $fault }
done-repair = Repaired: { $fault }
done-light = Fire at { $azimuth }°, { $range } m
done-sweep = Fires cleared away
done-power = Supply off for half a second
done-probe = Presence probe
done-bytes = { $count } bytes that are no frame

# Why no answer comes.
silence-broken = No answer: the monitor drops what is not a whole frame ({ $what }).
silence-address = No answer: the frame is for address { $dst }, not for this monitor.
silence-other = No answer: the monitor does not answer such a frame.

# What is wrong with a command, a text or a link.
command-too-long = The command is too long: { $most } bytes at most.
command-wrong = The page and the simulator do not fit together: reload the page ({ $error }).
no-profile = There is no profile of this name.
wind-at-most = The wind can have { $most } m/s at most.
no-fault = There is no fault “{ $name }”.
fire-where = A fire can be at -180…180° and { $from }…{ $to } m.
nothing-typed = Type a request, such as GetStatus All.
text-too-long = The text is too long: { $most } bytes at most.
requests-at-most = A frame takes { $most } requests here at most.
in-request = { $line }: { $says }
payload-at-most = A frame carries { $most } bytes of records at most: send fewer requests.
no-digit = “{ $wrong }” is no hexadecimal digit: type bytes such as 9d c8 00 02 fe 23.
half-byte = The last byte has one digit only: each byte has two.
bytes-at-most = { $most } bytes at most.
no-frame = These bytes are no frame: { $what }. They can be sent all the same; the monitor drops them.
session-full = This session is full: half an hour, 200 actions, 8 fires or 8000 characters of link. Start a new one.
link-too-long = The link is too long: { $most } characters at most. It is not one that this page has made.
link-version = The link does not begin like one of this version of the playground. Check that it was copied from its beginning, or start a new session.
link-damaged = The link is damaged: a letter is missing or has changed. Copy all of it again.
link-bounds = The link has contents that this version of the playground does not know, or is beyond its bounds. Start a new session.

# Faults.
fault-of = { $part }: { $what }
button-of = { $post }, { $button }
housing = Housing
